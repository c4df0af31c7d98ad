"""Rays and depth images: by hand on one triangle, then laws, then Embree against the z-buffer."""

import numpy as np

from mien.camera import Camera
from mien.mesh import Mesh
from mien.pictures import RayCaster, depth_image, frontal_camera
from mien.transforms import Transform, rotation_from_vector
from round_things import sphere

CAMERA = Camera(100.0, 100.0, 9.5, 9.5, 20, 20)


FACING = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 200.0]))
"""A camera 200 mm in front of face space's origin."""


def test_one_triangle_by_hand():
    """At z = 200 mm and f = 100 px a pixel is 2 mm: the square's lower left half, x and y in -6.5..6.5 mm."""
    mesh = Mesh(np.array([[-6.5, -6.5, 0.0], [6.5, -6.5, 0.0], [-6.5, 6.5, 0.0]]), np.array([[0, 1, 2]]))
    seen = depth_image(mesh, CAMERA, FACING)
    x, y = np.meshgrid(np.arange(20) - 9.5, 9.5 - np.arange(20))
    covered = (2 * x >= -6.5) & (2 * y >= -6.5) & (2 * x + 2 * y <= 0)
    np.testing.assert_array_equal(seen.faces == 0, covered)
    np.testing.assert_array_equal(seen.faces == -1, ~covered)
    np.testing.assert_allclose(seen.depth[covered], 200.0, rtol=1e-12)
    assert np.isnan(seen.depth[~covered]).all()
    assert np.isnan(seen.barycentric[~covered]).all()
    np.testing.assert_allclose(seen.barycentric[covered, 1], (2 * x[covered] + 6.5) / 13, atol=1e-12)
    np.testing.assert_allclose(seen.barycentric[covered, 2], (2 * y[covered] + 6.5) / 13, atol=1e-12)


def test_neighbours_leave_no_crack():
    """A fan of slivers that meet in many shared edges covers its square without a hole."""
    rng = np.random.default_rng(0)
    rim = np.column_stack([50 * np.cos(a := np.sort(rng.uniform(0, 2 * np.pi, 300))), 50 * np.sin(a), 0 * a])
    mesh = Mesh(np.vstack([[0.3, 0.7, 0.0], rim]), np.array([[0, i, i % 300 + 1] for i in range(1, 301)]))
    seen = depth_image(mesh, CAMERA.scaled(7.3), FACING)
    image = CAMERA.scaled(7.3)
    assert (seen.faces[20 : image.height - 20, 20 : image.width - 20] >= 0).all()


def test_depth_reprojects_onto_the_surface():
    mesh = sphere(50, 80)
    view = frontal_camera(mesh, (64, 48), yaw=0.4, pitch=-0.2)
    seen = depth_image(mesh, *view)
    v, u = np.nonzero(seen.faces >= 0)
    assert len(v) > 1000
    rays = view.camera.rays(np.stack([u, v], 1).astype(float))
    points = view.T_camera_face.inverse().apply(rays * seen.depth[v, u, None])
    corners = mesh.vertices[mesh.faces[seen.faces[v, u]]]
    np.testing.assert_allclose(points, np.einsum("pc,pcd->pd", seen.barycentric[v, u], corners), atol=1e-9)
    assert np.all(np.linalg.norm(points, axis=1) < 50.0 + 1e-9)
    assert np.all(np.linalg.norm(points, axis=1) > 50.0 - 0.05)


def test_embree_and_the_z_buffer_agree():
    """Far from the origin, where float32 would show."""
    mesh = sphere(60, 30, centre=(3000.0, -2000.0, 1000.0))
    view = frontal_camera(mesh, (80, 60), yaw=-0.3, pitch=0.5)
    caster = RayCaster(mesh)
    seen = caster.depth_image(*view)
    u, v = np.meshgrid(np.arange(80.0), np.arange(60.0))
    back = view.T_camera_face.inverse()
    ways = back.rotate(view.camera.rays(np.stack([u, v], -1)).reshape(-1, 3))
    hits = caster.cast(np.tile(back.translation, (len(ways), 1)), ways)
    np.testing.assert_array_equal(hits.hit, seen.faces.ravel() >= 0)
    same = hits.faces == seen.faces.ravel()
    assert same.mean() > 0.999  # on a shared edge either triangle is right
    np.testing.assert_allclose(hits.distances, seen.depth.ravel(), atol=1e-4)
    both = same & hits.hit
    np.testing.assert_allclose(hits.barycentric[both], seen.barycentric.reshape(-1, 3)[both], atol=1e-5)


def test_cast_by_hand():
    near = np.array([[0.0, 0, 5], [4, 0, 5], [0, 4, 5]])
    mesh = Mesh(np.concatenate([near, near + np.array([0.0, 0, 4])]), np.arange(6).reshape(2, 3))
    caster = RayCaster(mesh)
    origins = np.array([[1.0, 2, 0], [1, 2, 7], [1, 2, 12], [3, 3, 0], [1, 2, 0]])
    ways = np.array([[0.0, 0, 2], [0, 0, 1], [0, 0, -1], [0, 0, 1], [0, 0, -1]])
    hits = caster.cast(origins, ways)
    assert hits.faces.tolist() == [0, 1, 1, -1, -1]
    assert hits.hit.tolist() == [True, True, True, False, False]
    np.testing.assert_allclose(hits.distances, [2.5, 2, 3, np.nan, np.nan])
    np.testing.assert_allclose(hits.barycentric[:3], [[0.25, 0.25, 0.5]] * 3, atol=1e-12)
    assert np.isnan(hits.barycentric[3:]).all()
    np.testing.assert_allclose(hits.attachment().points(mesh), [[1, 2, 5], [1, 2, 9], [1, 2, 9]], atol=1e-12)
    assert caster.cast(origins, ways, reach=2.2).faces.tolist() == [-1, 1, -1, -1, -1]
    assert caster.occluded(origins, ways).tolist() == [True, True, True, False, False]
    assert caster.occluded(origins, ways, reach=2.2).tolist() == [False, True, False, False, False]


def test_what_reaches_behind_the_camera_is_seen_in_front_alone():
    """A floor that runs on behind the camera fills the picture's lower half, to the horizon."""
    floor = Mesh(np.array([[-1e5, 0, -1e5], [1e5, 0, -1e5], [0.0, 0, 2e5]]), np.array([[0, 1, 2]]))
    above = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 30.0, 0.0]))
    seen = depth_image(floor, CAMERA, above)
    assert (seen.faces[10:] == 0).all()
    assert (seen.faces[:10] == -1).all()
    np.testing.assert_allclose(seen.depth[15], 30 * 100 / 5.5)


def test_a_turned_mesh_before_a_turned_camera_looks_the_same():
    mesh = sphere(50, 20)
    camera, T_camera_face = frontal_camera(mesh, 60, yaw=0.3)
    turn = Transform(rotation_from_vector(np.array([0.4, -1.0, 0.7])), np.array([100.0, -20, 5]))
    moved = mesh.with_vertices(turn.apply(mesh.vertices))
    a = depth_image(mesh, camera, T_camera_face)
    b = depth_image(moved, camera, T_camera_face @ turn.inverse())
    assert (a.faces == b.faces).mean() > 0.999
    np.testing.assert_allclose(a.depth, b.depth, atol=1e-6)
