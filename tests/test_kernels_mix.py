"""Kernels that add up rows agree with their numpy twins."""

import numpy as np
import pytest

from mien._kernels import mix, mix_twin


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("length", [3, 512, 1300])
def test_products_and_combine(dtype, length):
    rng = np.random.default_rng(length)
    rows = rng.normal(size=(11, length)).astype(dtype)
    weights = rng.normal(size=(11, 4)).astype(dtype)
    accuracy = 1e-4 if dtype == np.float32 else 1e-12
    np.testing.assert_allclose(mix.products(rows, rows[2]), mix_twin.products(rows, rows[2]), atol=accuracy)
    combined = mix.combine(rows, weights)
    assert combined.dtype == dtype
    np.testing.assert_allclose(combined, mix_twin.combine(rows, weights), atol=accuracy)
