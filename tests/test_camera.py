"""The pinhole camera by hand, and the law that binds its two ways."""

import numpy as np

from mien.camera import Camera

CAMERA = Camera(fx=100.0, fy=110.0, cx=31.5, cy=23.5, width=64, height=48)


def test_projection_by_hand():
    pixels = CAMERA.project(np.array([[0.0, 0.0, 500.0], [50.0, -10.0, 200.0]]))
    np.testing.assert_allclose(pixels, [[31.5, 23.5], [56.5, 18.0]])


def test_rays_go_back_to_their_pixels_at_any_depth():
    pixels = np.random.default_rng(0).uniform(0, 60, (4, 5, 2))
    rays = CAMERA.rays(pixels)
    np.testing.assert_array_equal(rays[..., 2], 1.0)
    np.testing.assert_allclose(CAMERA.project(350.0 * rays), pixels)


def test_a_scaled_picture_shows_the_same_at_the_same_share():
    """Corners are half a pixel outside the outermost centres, whatever the size."""
    twice, points = CAMERA.scaled(2), np.array([[3.0, 4.0, 90.0]])
    assert (twice.width, twice.height) == (128, 96)
    np.testing.assert_allclose((twice.project(points) + 0.5) / 2, CAMERA.project(points) + 0.5)
