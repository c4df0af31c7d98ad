"""Shading kernels against their numpy twins."""

import numpy as np
import pytest

from mien._kernels import shade, shade_twin
from mien.pictures.color import LEVEL_OF_ROOT, LINEAR_OF_BYTE
from samples import surface_samples


@pytest.fixture
def rng():
    return np.random.default_rng(5)


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


def test_resolve_agrees_with_its_twin(rng):
    pixels = np.flatnonzero(rng.random(10 * 14) < 0.6)
    lit, backdrop = rng.random((len(pixels), 3), dtype=np.float32), rng.random((5, 7, 3), dtype=np.float32)
    kernel = shade.resolve(lit, pixels, backdrop, LEVEL_OF_ROOT, 2)
    twin = shade_twin.resolve(lit, pixels, backdrop, LEVEL_OF_ROOT, 2)
    for ours, theirs in zip(kernel, twin, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1 if ours.dtype == np.uint8 else 1e-6)
        assert np.mean(ours.astype(float) != theirs) < 0.02 or ours.dtype != np.uint8
