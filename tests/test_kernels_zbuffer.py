"""The z-buffer against its numpy twin."""

import numpy as np
import pytest

from mien._kernels import zbuffer, zbuffer_twin

INTRINSICS = (30.0, 31.0, 15.3, 11.7)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def triangle_soup(rng, count=40):
    corners = rng.uniform((-60, -50, 80), (60, 50, 160), (count, 1, 3)) + rng.normal(0, 25, (count, 3, 3))
    corners[0, 0, 2] = -5.0  # one that reaches behind the camera
    corners[1] -= (0, 0, 400)  # one wholly behind it
    corners[2, 2] = corners[2, 1]  # one without area
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


@pytest.mark.parametrize("threads", [1, 3])
def test_zbuffer_agrees_with_its_twin(rng, threads):
    points, faces = triangle_soup(rng)
    image, nearness = zbuffer.zbuffer(points, faces, INTRINSICS, 24, 32, threads)
    twin_image, twin_nearness = zbuffer_twin.zbuffer(points, faces, INTRINSICS, 24, 32)
    np.testing.assert_array_equal(image, twin_image)
    np.testing.assert_allclose(nearness, twin_nearness, rtol=1e-9, atol=1e-12)
    pixels = np.flatnonzero(image.ravel() >= 0)
    assert {0} < set(image.ravel().tolist())
    assert not {1, 2} & set(image.ravel().tolist())
    np.testing.assert_allclose(
        zbuffer.pixel_weights(points, faces, INTRINSICS, image, pixels, threads),
        zbuffer_twin.pixel_weights(points, faces, INTRINSICS, image, pixels),
        atol=1e-9,
    )
