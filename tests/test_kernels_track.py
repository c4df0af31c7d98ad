"""The tracker's loops against their numpy twins."""

import numpy as np
import pytest
import scipy.sparse as sp

import tracking_stage as stage
from kernel_scene import face_and_depth, matched
from mien._kernels import track, track_twin
from mien.mesh import vertex_normals
from mien.tracking.adaptive import Factored


@pytest.fixture(scope="module")
def scene():
    return face_and_depth()


def test_plane_offsets_and_mean_squares_agree(scene):
    model, T, points, *_ = scene
    found, plane, weight = matched(scene)
    offsets = track.plane_offsets(points, found, plane, weight, T.rotation)
    np.testing.assert_allclose(offsets, track_twin.plane_offsets(points, found, plane, weight, T.rotation), atol=1e-3)
    expected = track_twin.mean_square(model.share, offsets)
    assert track.mean_square(model.share, offsets) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("rows", [0, 3, 40, 41, 43])
def test_normal_equations_agree_for_any_number_of_rows(rows):
    rng = np.random.default_rng(rows)
    J, r = rng.normal(size=(rows, 7)).astype(np.float32), rng.normal(size=rows).astype(np.float32)
    for a, b in zip(track.normal_equations(J, r), track_twin.normal_equations(J, r), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-4)


def test_normals_and_placing_agree(scene):
    model, T, points, normals, _ = scene
    np.testing.assert_allclose(normals, vertex_normals(points.astype(float), model.faces), atol=1e-4)
    np.testing.assert_allclose(normals, track_twin.vertex_normals(points, model.faces), atol=1e-4)
    moved = track.place(model.neutral, T.rotation, T.translation)
    np.testing.assert_allclose(moved, track_twin.place(model.neutral, T.rotation, T.translation), atol=1e-3)


@pytest.mark.parametrize("size", [0.0, 1e-10, 0.3, 3.0])
def test_turning_a_pose_agrees(size):
    T, centre = stage.pose((0.1, 0.2, 0.3)), np.array([3.0, -2.0, 590.0])
    motion = np.array([0.6, -0.64, 0.48, 1.0, 2.0, 3.0]) * np.r_[np.full(3, size), np.ones(3)]
    fast, plain = (k.turned(T.rotation, T.translation, motion, centre) for k in (track, track_twin))
    for a, b in zip(fast, plain, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_factored_solves_agree_with_each_other_and_with_the_matrix():
    rng = np.random.default_rng(3)
    A = sp.random(60, 60, 0.1, random_state=4)
    A = A @ A.T + 2 * sp.identity(60)
    factor, right = Factored(A), rng.normal(size=(60, 3))
    found = factor.solve(right)
    np.testing.assert_allclose(A @ found, right, atol=1e-4)
    parts = (factor._starts, factor._indices, factor._values, factor._inverse, factor._order)
    np.testing.assert_allclose(found, track_twin.solve_factored(*parts, right), atol=1e-5)


def test_a_matrix_that_needs_pivoting_is_refused():
    with pytest.raises((ValueError, RuntimeError), match=r"pivoting|singular"):
        Factored(sp.csc_matrix(np.array([[0.0, 1.0], [1.0, 0.0]])))
