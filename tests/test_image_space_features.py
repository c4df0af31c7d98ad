"""Detail that is comparable between scans."""

from dataclasses import replace

import numpy as np

from mien.image_space.config import FeatureConfig, FineConfig
from mien.image_space.features import averaged, detail, over, raw_images
from mien.mesh import Mesh, SurfaceImage
from mien.register import Surface

PLAIN = FeatureConfig(threshold=0.0, saturation=np.inf, faint=1e-6, broad_mm=np.inf, nearby_mm=3.0)
WAVE = np.sin(np.arange(40) / 2.0)[:, None] * np.ones(30)


def test_an_average_of_one_value_is_that_value_and_knows_no_rim():
    known = np.zeros((20, 20), bool)
    known[5:12, 5:12] = True
    np.testing.assert_allclose(averaged(np.full((20, 20), 3.0), known, 2.0)[known], 3.0)


def test_small_values_of_either_sign_are_noise():
    found = over(np.array([[-2.0, -0.5, 0.5, 2.0, np.nan]]), 1.0)
    np.testing.assert_array_equal(found == 0, [[False, True, True, False, False]])
    assert np.isnan(found[0, 4])


def test_shallow_and_deep_detail_become_alike():
    once, twice = detail(WAVE, PLAIN, 1.0), detail(2 * WAVE, PLAIN, 1.0)
    np.testing.assert_allclose(twice.scaled, once.scaled, atol=1e-4)
    faint = detail(WAVE * 1e-8, PLAIN, 1.0)
    assert faint.evidence.max() < 1e-3 < 0.9 < once.evidence[20, 15]


def test_where_there_is_no_data_there_is_no_evidence():
    holed = WAVE.copy()
    holed[10:20, 10:20] = np.nan
    found = detail(holed, PLAIN, 1.0)
    assert not found.scaled[10:20, 10:20].any()
    assert not found.evidence[10:20, 10:20].any()


def test_broad_detail_is_taken_out():
    slope = np.linspace(0, 10, 40)[:, None] * np.ones(30)
    narrow = detail(WAVE + slope, replace(PLAIN, broad_mm=4.0), 1.0).scaled
    assert abs(narrow[10:30, 5:25].mean()) < 0.1


def test_curvature_and_luminance_are_the_scans():
    x, y = np.meshgrid(np.linspace(-20.0, 20, 9), np.linspace(-20.0, 20, 9))
    vertices = np.stack([x, y, np.sqrt(60.0**2 - x**2 - y**2)], -1).reshape(-1, 3)
    index = np.arange(81).reshape(9, 9)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    ball = Mesh(vertices, faces, colors=np.full((81, 3), 0.5))
    image = SurfaceImage(vertices[:, :2] + 25, faces, (50, 50))
    config = FineConfig(curvature_radius_mm=8.0)
    curvature, luminance = raw_images(ball, image, Surface(ball), config)
    np.testing.assert_allclose(np.abs(curvature[20:30, 20:30]), 1 / 60, rtol=0.1)
    np.testing.assert_allclose(luminance[20:30, 20:30], 0.5)
    assert np.isnan(curvature[0, 0])
    assert raw_images(ball, image, None, config)[1] is None
    assert raw_images(ball, image, Surface(ball), replace(config, colour=None))[1] is None
