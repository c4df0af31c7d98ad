"""Kernels of the bounded least squares agree with their numpy twins."""

import numpy as np
import pytest

from mien._kernels import boxls, boxls_smooth, boxls_smooth_twin, boxls_twin


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("warm", [False, True])
def test_boxls(own, warm):
    rng = np.random.default_rng(0)
    matrices = rng.normal(size=(40 if own else 1, 20, 9))
    grams = np.einsum("tri,trj->tij", matrices, matrices)
    linear = 5 * rng.normal(size=(40, 9))
    start = rng.uniform(0, 1, (40 if warm else 0, 9))
    lower, upper = np.zeros(9), np.linspace(0.1, 1, 9)
    kernel = boxls.boxls(grams, linear, lower, upper, start, 1e-10)
    twin = boxls_twin.boxls(grams, linear, lower, upper, start, 1e-10)
    np.testing.assert_allclose(kernel[0], twin[0], atol=1e-9)
    assert kernel[1].max() < 1e-10
    assert twin[1].max() < 1e-10


@pytest.mark.parametrize("own", [False, True])
def test_smooth_slope_and_band(own):
    rng = np.random.default_rng(1)
    frames, k = 12, 5
    halves = rng.normal(size=(frames if own else 1, k, k))
    grams, links = halves @ halves.transpose(0, 2, 1), rng.normal(size=(3, frames))
    linear, values = rng.normal(size=(2, frames, k))
    np.testing.assert_allclose(
        boxls_smooth.smooth_slope(grams, linear, links, values),
        boxls_smooth_twin.smooth_slope(grams, linear, links, values),
        atol=1e-12,
    )
    free = rng.random((frames, k)) > 0.4
    order = (np.cumsum(free.ravel()) - free.ravel()).reshape(free.shape)
    np.testing.assert_allclose(
        boxls_smooth.smooth_band(grams, links, free, order, 3 * k, 0.1),
        boxls_smooth_twin.smooth_band(grams, links, free, order, 3 * k, 0.1),
        atol=1e-12,
    )
