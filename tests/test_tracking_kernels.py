"""The tracker's compiled loops against their numpy twins."""

import numpy as np
import pytest
import scipy.sparse as sp

import tracking_stage as stage
from mien._kernels import icp, icp_twin, track, track_fit, track_fit_twin, track_twin, tsdf, tsdf_twin
from mien.mesh import vertex_normals
from mien.tracking.adaptive import Factored
from mien.tracking.packed_basis import LEAST

INTRINSICS = np.array([262.5, 262.5, 159.5, 119.5])


@pytest.fixture(scope="module")
def scene():
    """A face beside its own depth image, so that there is something to correspond."""
    rig, model = stage.person(), stage.model()
    frame = stage.sensed(rig, stage.named(rig, jawOpen=0.3), stage.pose((0.05, 0.1, 0), (2, 1, 4)), noise=0.5)
    T = stage.pose()
    points = T.apply(model.neutral.astype(float)).astype(np.float32)
    normals = track.vertex_normals(points, model.faces)
    return model, T, points, normals, frame.depth


def matched(scene):
    _, _, points, normals, depth = scene
    return icp.correspond(points, normals, depth, INTRINSICS, np.float32(25), np.float32(0.3), 2)


def test_correspondences_agree(scene):
    _, _, points, normals, depth = scene
    fast = matched(scene)
    plain = icp_twin.correspond(points, normals, depth, INTRINSICS, 25.0, 0.3, 2)
    same = (fast[2] > 0) == (plain[2] > 0)
    assert same.mean() > 0.998
    assert (fast[2] > 0).sum() > 500
    for a, b, tolerance in zip(fast, plain, (2e-3, 2e-3, 1e-3), strict=True):
        np.testing.assert_allclose(a[same], b[same], atol=tolerance)


def test_rigid_system_agrees(scene):
    found, plane, weight = matched(scene)
    centre = np.array([0.0, 0.0, 600.0])
    fast = icp.rigid_system(scene[2], found, plane, weight, centre, 6.0)
    plain = icp_twin.rigid_system(scene[2], found, plane, weight, centre, 6.0)
    np.testing.assert_allclose(fast[0], plain[0], rtol=1e-4, atol=1e-3 * abs(plain[0]).max())
    np.testing.assert_allclose(fast[1], plain[1], atol=1e-3 * abs(plain[1]).max())
    assert fast[2] == pytest.approx(plain[2], rel=1e-4)
    assert fast[3] == plain[3]


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


def test_integration_agrees():
    rng = np.random.default_rng(5)
    depth = rng.uniform(570, 630, (240, 320)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.1] = 0
    T, volumes = stage.pose((0.1, 0.2, 0)), []
    for module in (tsdf, tsdf_twin):
        distance, weight = np.ones((20, 22, 24), np.float32), np.zeros((20, 22, 24), np.float32)
        for _ in range(2):
            corner = np.array([-20.0, -22, -24])
            module.integrate(distance, weight, corner, 2.0, T.rotation, T.translation, depth, INTRINSICS, 6.0, 9.0)
        volumes.append((distance, weight))
    for a, b in zip(*volumes, strict=True):
        assert (a != b).mean() < 1e-3
        np.testing.assert_allclose(np.median(np.abs(a - b)), 0, atol=1e-6)
    assert volumes[0][1].max() == 2
