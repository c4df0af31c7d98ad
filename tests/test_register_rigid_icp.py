"""Rounds of closest points, and the system that moves a head in each."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.mesh import ClosestPoint, Mesh, submesh
from mien.register import IcpConfig, Rejection, Surface, icp
from mien.register.rigid_icp import closest_point_rounds, plane_system, point_system, weighted_centre
from mien.transforms import Transform, rotation_from_vector
from test_register_rigid import some_transform


def bumpy(n=41, size=100.0):
    """A patch with hills, so that a surface fixes all six freedoms."""
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    z = 0.25 * np.sin(3 * u + 0.5) * np.cos(2.5 * v) + 0.2 * u * v - 0.2 * u**2
    vertices = size / 2 * np.stack([u, v, z], -1).reshape(-1, 3)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def test_rounds_end_where_one_says_so_or_where_they_run_out():
    found = closest_point_rounds(16, lambda n: (n // 2, n // 2 < 3), 10)
    assert (found.state, found.settled, found.done) == (2, True, 3)
    short = closest_point_rounds(16, lambda n: (n // 2, n // 2 < 3), 2)
    assert (short.state, short.settled, short.done) == (4, False, 2)


def test_a_system_finds_a_small_motion_of_planes_and_points():
    """Exact to first order; a further unknown lifts every point along its normal; nothing to pull moves nothing."""
    rng = np.random.default_rng(0)
    points, normals, weights = rng.normal(0, 50, (40, 3)), rng.normal(size=(40, 3)), rng.uniform(0.1, 1, 40)
    centre = weighted_centre(points, weights)
    T = Transform(rotation_from_vector(np.array([2e-6, -1e-6, 3e-6])), np.array([1e-4, 2e-4, -3e-4]))
    shift = T.apply(points) - points
    off = (shift * normals).sum(1)
    for system in (plane_system(points, normals, off, weights), point_system(points, shift, weights, centre)):
        np.testing.assert_allclose(system.solve()[0].apply(points), T.apply(points), atol=1e-8)
    lifted = plane_system(points, normals, off + 0.5, weights, np.ones((40, 1))).solve()
    np.testing.assert_allclose(lifted[1], [0.5], atol=1e-6)
    still, _ = plane_system(points, normals, off, 0 * weights).solve()
    np.testing.assert_array_equal(still.apply(points), points)


def test_what_else_is_free_is_drawn_to_nothing_as_far_as_it_is_held():
    """Forty planes a millimetre off and one column of ones, at 2: the least of 40 (x - 1)^2 + 10 (2 + x)^2 is 0.4."""
    nothing = np.zeros((40, 3))
    system = plane_system(nothing, nothing, np.ones(40), np.ones(40), np.ones((40, 1)))
    _, more = system.held(np.array([2.0]), np.array([10.0])).solve()
    np.testing.assert_allclose(more, [(40 - 20) / 50], rtol=1e-6)


@pytest.mark.parametrize("metric", ["plane", "point"])
def test_icp_finds_a_small_motion(metric):
    mesh = bumpy()
    T = Transform(rotation_from_vector(np.array([0.05, -0.08, 0.06])), np.array([2.0, -1, 1.5]))
    moved = mesh.with_vertices(T.inverse().apply(mesh.vertices))
    config = IcpConfig(metric=metric, iterations=500, tolerance=1e-6)
    found = icp(moved, ClosestPoint(mesh), config=config)
    assert found.converged
    assert np.linalg.norm(found.transform.apply(moved.vertices) - mesh.vertices, axis=1).max() < 0.01
    assert found.rms < 0.01


def test_icp_with_scale():
    mesh = bumpy()
    inner, _ = submesh(mesh, np.linalg.norm(mesh.vertices[mesh.faces].mean(1)[:, :2], axis=1) < 30)
    T = Transform(rotation_from_vector(np.array([0.03, -0.02, 0.04])), np.array([1.0, -1, 0.5]), 1.04)
    moved = inner.with_vertices(T.inverse().apply(inner.vertices))
    found = icp(moved, ClosestPoint(mesh), config=IcpConfig(scale=True, iterations=200, tolerance=1e-6))
    np.testing.assert_allclose(found.transform.scale, 1.04, atol=1e-3)
    assert np.linalg.norm(found.transform.apply(moved.vertices) - inner.vertices, axis=1).max() < 0.05


def test_icp_moves_with_its_input():
    """Turning source, target and start together turns the answer."""
    mesh = bumpy(21)
    T = Transform(rotation_from_vector(np.array([0, 0.05, 0.03])), np.ones(3))
    moved = mesh.with_vertices(T.apply(mesh.vertices))
    Q = some_transform(1.3)
    plain = icp(moved, ClosestPoint(mesh), config=IcpConfig(iterations=5))
    turned = icp(
        moved.with_vertices(Q.apply(moved.vertices)),
        ClosestPoint(mesh.with_vertices(Q.apply(mesh.vertices))),
        config=IcpConfig(iterations=5),
    )
    np.testing.assert_allclose(
        turned.transform.apply(Q.apply(moved.vertices)), Q.apply(plain.transform.apply(moved.vertices)), atol=1e-6
    )


@pytest.mark.parametrize("guard", [{"keep": 0.65}, {"robust": "tukey"}])
def test_a_third_of_outliers_does_no_harm(guard):
    mesh = bumpy()
    rng = np.random.default_rng(5)
    T = Transform(rotation_from_vector(np.array([0.04, -0.05, 0.03])), np.array([1.0, -1.5, 1]))
    points = T.inverse().apply(mesh.vertices)
    wrong = rng.random(len(points)) < 0.3
    points[wrong] += rng.normal(size=(wrong.sum(), 3)) * 6 + [0, 0, 14]
    free = Rejection(max_angle_deg=180.0, boundary=False)
    error = {}
    for name, options in (("guarded", guard), ("plain", {})):
        found = icp(points, ClosestPoint(mesh), config=IcpConfig(rejection=free, iterations=200, **options))
        error[name] = np.linalg.norm(found.transform.apply(points)[~wrong] - mesh.vertices[~wrong], axis=1).mean()
    assert error["guarded"] < 0.05
    assert error["plain"] > 10 * error["guarded"]


def test_a_plane_slides_on_itself_without_moving():
    n = np.arange(6)
    x, y = np.meshgrid(n, n)
    square = Mesh(
        np.array([[-50.0, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    )
    points = np.stack([x.ravel(), y.ravel(), np.full(36, 3.0)], 1)
    found = icp(points, ClosestPoint(square))
    np.testing.assert_allclose(found.transform.apply(points), points * [1, 1, 0], atol=1e-9)


def test_rejections_by_hand():
    corners = np.array([[0.0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0], [5, 5, 0]])
    square = Mesh(corners, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]))
    surface = Surface(square)
    points = np.array([[5.0, 4, 1], [15, 5, 0], [5, 4, 9], [5, 4, 1]])
    up = np.array([[0.0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, -1]])
    found = surface.correspond(points, up, Rejection(max_distance=6.0))
    np.testing.assert_array_equal(found.accepted, [True, False, False, False])
    np.testing.assert_allclose(found.points, [[5, 4, 0], [10, 5, 0], [5, 4, 0], [5, 4, 0]], atol=1e-12)
    np.testing.assert_allclose(found.normals, [[0, 0, 1]] * 4, atol=1e-12)
    np.testing.assert_allclose(found.attachment().points(square), found.points, atol=1e-12)
    lax = surface.correspond(points, up, Rejection(max_angle_deg=180.0, boundary=False))
    assert lax.accepted.all()


def test_icp_with_nothing_near_says_so():
    mesh = bumpy(11)
    far = IcpConfig(rejection=Rejection(max_distance=1.0))
    with pytest.raises(BadInput, match="closest point"):
        icp(mesh.vertices + 1000, ClosestPoint(mesh), config=far)


def test_points_count_by_their_weights_and_the_others_are_not_looked_at():
    """Half of a patch is lifted: told that it does not count, or robustly, the other half is found all the same."""
    mesh, T = bumpy(), some_transform(angle=0.02, seed=5)
    lifted = mesh.vertices + np.where(mesh.vertices[:, :1] > 10, [0.0, 0.0, 2.0], 0.0)
    start, target = T.inverse(), ClosestPoint(mesh)
    moved = T.apply(lifted)
    told = icp(moved, target, start, weights=(mesh.vertices[:, 0] <= 10).astype(float))
    np.testing.assert_allclose(told.transform.apply(T.apply(mesh.vertices)), mesh.vertices, atol=0.05)
    assert (told.weights[mesh.vertices[:, 0] > 10] == 0).all()
    robust = icp(moved, target, start, IcpConfig(robust="geman"))
    plain = icp(moved, target, start)
    off = [np.abs(found.transform.apply(moved) - lifted).max() for found in (robust, plain)]
    assert off[0] < 0.1 < 0.5 < off[1]
