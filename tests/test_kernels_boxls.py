"""Kernels of the bounded least squares agree with their numpy twins."""

import numpy as np
import pytest

from mien._kernels import boxls, boxls_twin


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
