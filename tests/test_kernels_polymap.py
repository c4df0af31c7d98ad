import numpy as np
import pytest

from mien._kernels import polymap, polymap_twin
from mien.detail.polynomial import EXPONENTS


@pytest.mark.parametrize("order", [1, 2, 3])
def test_accumulate_agrees_with_its_twin(order):
    rng, exponents = np.random.default_rng(order), EXPONENTS[order]
    m = len(exponents)
    d, f = rng.normal(size=(40, 2)), rng.normal(size=(40, 3))
    weights = (rng.random(40) > 0.3) * rng.random(40)
    one, two = ((np.zeros((40, m * (m + 1) // 2)), np.zeros((40, m, 3))) for _ in range(2))
    for _ in range(2):
        polymap.accumulate(*one, d, f, weights, exponents)
        polymap_twin.accumulate(*two, d, f, weights, exponents)
    for a, b in zip(one, two, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_evaluate_agrees_with_its_twin(order):
    rng, exponents = np.random.default_rng(order), EXPONENTS[order]
    coefficients = rng.normal(size=(30, len(exponents), 3)).astype(np.float32)
    d = rng.normal(size=(30, 2)).astype(np.float32)
    a, b = np.empty((30, 3), np.float32), np.empty((30, 3), np.float32)
    polymap.evaluate(coefficients, d, exponents, a)
    polymap_twin.evaluate(coefficients, d, exponents, b)
    np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-5)
    if order == 2:
        polymap.evaluate_quadratic(coefficients, d, a)
        np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-5)


def test_parameter_fields_agree_with_their_twin():
    rng = np.random.default_rng(4)
    vectors, bases = rng.normal(size=(6, 5)).astype(np.float32), rng.normal(size=(20, 5, 2)).astype(np.float32)
    corners = rng.integers(0, 6, (20, 3)).astype(np.int32)
    weights = rng.dirichlet(np.ones(3), 20).astype(np.float32)
    a, b = np.empty((20, 2), np.float32), np.empty((20, 2), np.float32)
    polymap.parameter_fields(vectors, corners, weights, bases, a)
    polymap_twin.parameter_fields(vectors, corners, weights, bases, b)
    np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-5)
