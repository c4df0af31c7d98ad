"""Compiled picture kernels agree with their numpy twins."""

import numpy as np
import pytest

from mien._kernels import shade, shade_twin, zbuffer, zbuffer_twin
from mien.pictures.color import LEVEL_OF_ROOT, LINEAR_OF_BYTE

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


def test_interpolation_and_texture_agree_with_their_twins(rng):
    values, corners = rng.normal(size=(9, 4)), rng.integers(0, 9, (50, 3))
    weights = rng.dirichlet((1, 1, 1), 50)
    kernel = shade.interpolate(values, corners, weights, threads=2)
    np.testing.assert_allclose(kernel, shade_twin.interpolate(values, corners, weights), atol=1e-6)
    texture = rng.integers(0, 256, (7, 5, 3), dtype=np.uint8)
    uv = rng.uniform(-1.5, 2.5, (200, 2)).astype(np.float32)
    kernel = shade.bilinear(texture, LINEAR_OF_BYTE, uv, threads=2)
    np.testing.assert_allclose(kernel, shade_twin.bilinear(texture, LINEAR_OF_BYTE, uv), atol=2e-5)


def test_lift_agrees_with_its_twin(rng):
    points, normals = rng.normal(size=(9, 3)), rng.normal(size=(9, 3))
    corners, weights = rng.integers(0, 9, (50, 3)), rng.dirichlet((1, 1, 1), 50)
    kernel = shade.lift(points, normals, corners, weights, threads=2)
    np.testing.assert_allclose(kernel, shade_twin.lift(points, normals, corners, weights), atol=1e-6)


def surface_samples(rng, count=300):
    return {
        "normals": rng.normal(size=(count, 3)).astype(np.float32) * 3,
        "points": (rng.normal(size=(count, 3)) * 50 + (0, 0, 400)).astype(np.float32),
    }


def test_light_agrees_with_its_twin(rng):
    samples = surface_samples(rng)
    count = len(samples["points"])
    directions = rng.normal(size=(3, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    scene = dict(
        **samples,
        albedo=rng.random((count, 3), dtype=np.float32),
        open_sky=rng.random(count, dtype=np.float32),
        shadow=rng.random(count, dtype=np.float32),
        wet=rng.random(count, dtype=np.float32),
        lamps=np.column_stack([directions, rng.random((3, 4))]),
        ambient=rng.random((2, 3)),
        skin=np.array([0.3, 0.2, 0.0, 0.04, 0.4]),
    )
    np.testing.assert_allclose(shade.light(**scene, threads=2), shade_twin.light(**scene), atol=2e-5)


def test_soft_shadow_agrees_with_its_twin(rng):
    samples = surface_samples(rng)
    scene = dict(
        **samples,
        lamp=np.array([0.0, 0.0, -1.0]),
        depth=rng.uniform(380, 420, (40, 40)).astype(np.float32),
        pose=np.eye(3, 4),
        lens=np.array([60.0, 19.5, 8.0]),
    )
    kernel = shade.soft_shadow(**scene, threads=2)
    np.testing.assert_allclose(kernel, shade_twin.soft_shadow(**scene), atol=1e-4)
    assert kernel[kernel > 0].std() > 0.1


def test_resolve_agrees_with_its_twin(rng):
    pixels = np.flatnonzero(rng.random(10 * 14) < 0.6)
    lit, backdrop = rng.random((len(pixels), 3), dtype=np.float32), rng.random((5, 7, 3), dtype=np.float32)
    kernel = shade.resolve(lit, pixels, backdrop, LEVEL_OF_ROOT, 2)
    twin = shade_twin.resolve(lit, pixels, backdrop, LEVEL_OF_ROOT, 2)
    for ours, theirs in zip(kernel, twin, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1 if ours.dtype == np.uint8 else 1e-6)
        assert np.mean(ours.astype(float) != theirs) < 0.02 or ours.dtype != np.uint8
