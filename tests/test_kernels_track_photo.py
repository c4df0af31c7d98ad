"""The photometric loops against their numpy twins, and the plane that they give by hand."""

import numpy as np
import pytest

from mien._kernels import track_photo, track_photo_twin

INTRINSICS = np.array([50.0, 52.0, 19.3, 14.6])


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.mark.parametrize("radius", [1, 4, 30])
def test_box_agrees_with_its_twin(rng, radius):
    image = rng.random((12, 17), dtype=np.float32)
    np.testing.assert_allclose(track_photo.box(image, radius), track_photo_twin.box(image, radius), atol=2e-5)


def test_grey_agrees_with_its_twin(rng):
    color = rng.integers(0, 256, (7, 9, 3), dtype=np.uint8)
    np.testing.assert_allclose(track_photo.grey(color), track_photo_twin.grey(color), atol=1e-3)


def test_planes_agree_with_their_twin(rng):
    image = rng.random((30, 40), dtype=np.float32)
    points = (rng.normal(size=(200, 3)) * (60, 40, 60) + (0, 0, 150)).astype(np.float32)
    normals = rng.normal(size=(200, 3))
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    reference, valid = rng.random((2, 200), dtype=np.float32)
    arguments = (points, normals, image, INTRINSICS, reference, valid, np.float32(0.3))
    fast, plain = track_photo.sample_plane(*arguments), track_photo_twin.sample_plane(*arguments)
    assert (plain[2] > 0).sum() > 20
    for a, b in zip(fast, plain, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-3)


def test_a_ramp_is_met_where_it_shows_what_it_should():
    """Where a picture brightens by 0.01 a pixel, a vertex that should show 0.05 more belongs 5 pixels to the right."""
    image = np.tile(np.arange(40, dtype=np.float32) * np.float32(0.01), (30, 1))
    point = np.array([[0.0, 0.0, 100.0]], np.float32)
    shown = np.float32(0.01 * INTRINSICS[2])
    arguments = (point, np.array([[0, 0, -1.0]], np.float32), image, INTRINSICS)
    one = np.ones(1, np.float32)
    found, plane, weight, seen = track_photo.sample_plane(*arguments, one * (shown + np.float32(0.05)), one, 0.3)
    np.testing.assert_allclose(seen, shown, atol=1e-6)
    np.testing.assert_allclose(found[0], [10.0, 0, 100], atol=1e-3)  # 5 pixels are 10 mm at 100 mm and 50 pixels
    np.testing.assert_allclose(plane[0] / np.linalg.norm(plane[0]), [1, 0, 0], atol=1e-6)
    assert weight[0] == pytest.approx(1.0)
