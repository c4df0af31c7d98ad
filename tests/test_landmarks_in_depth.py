"""Landmarks as points of a depth image."""

import numpy as np

from mien.camera import Camera
from mien.landmarks.detector import COUNT, Landmarks2D
from mien.landmarks.in_depth import lifted

CAMERA = Camera(100.0, 100.0, 9.5, 9.5, 20, 20)


def test_a_landmark_is_the_median_of_nine_pixels_and_nan_without_depth():
    depth = np.full((20, 20), 500.0, np.float32)
    depth[5, 5] = 2000.0
    depth[12:, :] = 0
    pixels = np.full((COUNT, 2), 5.0)
    pixels[1], pixels[2], pixels[3] = (10, 15), (-3, 4), (np.nan, 4)
    points = lifted(depth, Landmarks2D(pixels, np.zeros(COUNT), {}), CAMERA)
    np.testing.assert_allclose(points[0], [500 * -4.5 / 100, 500 * -4.5 / 100, 500])
    assert np.isnan(points[1:4, 2]).all()
