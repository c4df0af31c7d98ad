"""Slope and Newton matrix of the smooth box-constrained solve agree with their numpy twins."""

import numpy as np
import pytest

from mien._kernels import boxls_smooth, boxls_smooth_twin


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
