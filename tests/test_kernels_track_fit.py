"""The blendshape fit's loops against their numpy twins."""

import numpy as np
import pytest

import tracking_stage as stage
from kernel_scene import face_and_depth, matched
from mien._kernels import track_fit, track_fit_twin
from mien.tracking.packed_basis import LEAST


@pytest.fixture(scope="module")
def scene():
    return face_and_depth()


def test_plane_systems_agree(scene):
    model, T, points, *_ = scene
    found, plane, weight = matched(scene)
    packed = (model.packed_basis.order, model.packed_basis.columns, model.packed_basis.values)
    centre = np.array([0.0, 0.0, 600.0])
    arguments = (*packed, 52, T.rotation, points, found, plane, weight, model.share, centre, 12.0, 100.0)
    fast, plain = track_fit.plane_system(*arguments), track_fit_twin.plane_system(*arguments)
    for a, b in zip(fast, plain, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-4 * np.abs(b).max())


def test_nothing_that_corresponds_gives_an_empty_system(scene):
    model, T, points, *_ = scene
    found, plane, weight = matched(scene)
    packed = (model.packed_basis.order, model.packed_basis.columns, model.packed_basis.values)
    arguments = (points, found, plane, 0 * weight, model.share, np.zeros(3), 12.0, 100.0)
    A, b, error, covered = track_fit.plane_system(*packed, 52, T.rotation, *arguments)
    assert not A.any()
    assert not b.any()
    assert (error, covered) == (0.0, 0.0)


def test_blends_agree_with_each_other_and_with_the_basis(scene):
    model, weights = scene[0], np.random.default_rng(0).random(52)
    packed = (model.packed_basis.order, model.packed_basis.columns, model.packed_basis.values)
    fast = track_fit.blend(model.neutral, *packed, weights)
    np.testing.assert_allclose(fast, track_fit_twin.blend(model.neutral, *packed, weights), atol=1e-4)
    np.testing.assert_allclose(fast, model.neutral + model.basis @ weights, atol=52 * LEAST)
    assert sorted(packed[0][packed[0] >= 0]) == list(range(len(model.neutral)))


def test_landmark_rows_agree(scene):
    model, T, rng = scene[0], stage.pose((0.1, 0.2, 0.3)), np.random.default_rng(0)
    neutral, basis = model.landmark_neutral[:40].copy(), model.landmark_basis[:40].copy()
    arguments = (neutral, basis, rng.random(52), T.rotation, T.translation, rng.normal(size=3), 100.0)
    for a, b in zip(track_fit.landmark_rows(*arguments), track_fit_twin.landmark_rows(*arguments), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)
