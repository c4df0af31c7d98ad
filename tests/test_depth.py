"""Depth images: frames, windows, cleaning, normals."""

import numpy as np
import pytest

from mien import depth as d
from mien._kernels import track_depth, track_depth_twin
from mien.camera import Camera
from mien.errors import BadInput

CAMERA = Camera(fx=100.0, fy=110.0, cx=31.5, cy=23.5, width=64, height=48)


def plane(normal, distance):
    """Depth of the plane normal . p = distance under CAMERA."""
    y, x = np.mgrid[: CAMERA.height, : CAMERA.width].astype(float)
    rays = CAMERA.rays(np.stack([x, y], -1))
    return (distance / (rays @ normal)).astype(np.float32)


def holed(seed=0):
    """A noisy plane with holes of both kinds."""
    rng = np.random.default_rng(seed)
    depth = plane(np.array([0.1, -0.2, 1.0]), 500.0) + rng.normal(0, 1, (48, 64)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.1] = 0
    depth[rng.random(depth.shape) < 0.05] = np.nan
    return depth


def test_frame_refuses_sizes_that_differ_and_emptiness():
    with pytest.raises(BadInput, match="64 x 48 and depth is 32 x 24"):
        d.RGBDFrame(np.zeros((48, 64, 3), np.uint8), np.zeros((24, 32), np.float32), 0.0)
    with pytest.raises(BadInput, match="neither"):
        d.RGBDFrame(None, None, 1.0)


def test_unproject_then_project_gives_the_pixel_and_the_depth_back():
    depth = holed()
    points = d.unproject(depth, CAMERA)
    some = d.valid(depth)
    y, x = np.nonzero(some)
    np.testing.assert_allclose(CAMERA.project(points[some].astype(float)), np.stack([x, y], 1), atol=1e-3)
    np.testing.assert_array_equal(points[some][:, 2], depth[some])
    assert np.isnan(points[~some]).all()


def test_normals_of_a_plane_are_the_plane_s_towards_the_camera():
    normal = np.array([0.1, -0.2, 1.0])
    found = d.normals_image(plane(normal, 500.0), CAMERA, step=2)
    expected = -normal / np.linalg.norm(normal)
    np.testing.assert_allclose(found[2:-2, 2:-2], np.broadcast_to(expected, (44, 60, 3)), atol=2e-4)
    assert (found[:2] == 0).all()
    assert (found[:, -2:] == 0).all()


def test_no_normal_across_a_jump():
    depth = plane(np.array([0.0, 0.0, 1.0]), 500.0)
    depth[:, 32:] += 100
    found = d.normals_image(depth, CAMERA, step=1, jump=20.0)
    assert (found[:, 31:33] == 0).all()
    assert (found[1:-1, 1:31, 2] == -1).all()


def test_bilateral_calms_noise_and_keeps_a_step():
    rng = np.random.default_rng(1)
    depth = np.full((48, 64), 500, np.float32)
    depth[:, 32:] = 560
    smooth = d.bilateral((depth + rng.normal(0, 1, depth.shape)).astype(np.float32), 2, 4.0)
    assert np.abs(smooth - depth).mean() < 0.3 * np.sqrt(2 / np.pi)
    assert np.abs(smooth - depth)[:, 31:33].max() < 2


def test_median_removes_a_flying_pixel_and_fills_no_hole():
    depth = np.full((5, 5), 500, np.float32)
    depth[2, 2], depth[0, 0] = 700, 0
    out = d.median(depth)
    assert out[2, 2] == 500
    assert out[0, 0] == 0


@pytest.mark.parametrize("name", ["bilateral", "median3", "normals"])
def test_kernels_agree_with_their_twins(name):
    arguments = {"bilateral": (2, np.float32(4.0)), "median3": (), "normals": (100.0, 110.0, 31.5, 23.5, 2, 20.0)}[name]
    fast, plain = (getattr(m, name)(holed(), *arguments) for m in (track_depth, track_depth_twin))
    np.testing.assert_allclose(fast, plain, atol=2e-3 if name != "normals" else 1e-4)


def test_window_stays_inside_and_keeps_its_least_size():
    camera = Camera(500.0, 500.0, 319.5, 239.5, 640, 480)
    window = d.window_around(np.array([[300.0, 200.0], [340.0, 260.0]]), camera)
    assert (window.width, window.height) == (200, 200)
    edge = d.window_around(np.array([[-50.0, -50.0], [10.0, 10.0]]), camera)
    assert (edge.x, edge.y) == (0, 0)
    point = np.array([[30.0, -20.0, 600.0]])
    np.testing.assert_allclose(window.camera(camera).project(point), camera.project(point) - [window.x, window.y])
