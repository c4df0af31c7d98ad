import numpy as np
import pytest

from mien._kernels import polymap, polymap_twin
from mien.detail.polynomial import exponents


@pytest.mark.parametrize(("order", "whole"), [(1, False), (2, True), (3, False)])
def test_accumulate_agrees_with_its_twin(order, whole):
    rng, powers = np.random.default_rng(order), exponents(order, whole)
    m = len(powers)
    d, f = rng.normal(size=(40, powers.shape[1])), rng.normal(size=(40, 3))
    weights = (rng.random(40) > 0.3) * rng.random(40)
    f[7, 1] = np.nan
    shapes = ((40, m * (m + 1) // 2), (40, m, 3), (40,), (40,))
    one, two = ([np.zeros(shape) for shape in shapes] for _ in range(2))
    for _ in range(2):
        polymap.accumulate(*one, d, f, weights, powers)
        polymap_twin.accumulate(*two, d, f, weights, powers)
    for a, b in zip(one, two, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12)


@pytest.mark.parametrize(("order", "whole"), [(1, False), (2, True), (3, False)])
def test_evaluate_agrees_with_its_twin(order, whole):
    rng, powers = np.random.default_rng(order), exponents(order, whole)
    coefficients = rng.normal(size=(30, len(powers), 3)).astype(np.float32)
    d = rng.normal(size=(30, powers.shape[1])).astype(np.float32)
    a, b = np.empty((30, 3), np.float32), np.empty((30, 3), np.float32)
    polymap.evaluate(coefficients, d, powers, a)
    polymap_twin.evaluate(coefficients, d, powers, b)
    np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-5)


def scattered(points=9000):
    """Forms of six triangles, points in runs of them, weights and planes of three channels."""
    rng = np.random.default_rng(4)
    triangle = np.repeat(rng.integers(0, 6, points // 9), 9).astype(np.int32)
    forms = rng.normal(size=(6, 2, 6)).astype(np.float32)
    weights = rng.dirichlet(np.ones(3), points).astype(np.float32).T[:2].copy()
    runs = np.concatenate([[0], np.flatnonzero(np.diff(triangle)) + 1, [points]]).astype(np.int32)
    planes = rng.normal(size=(3, 8, points)).astype(np.float32)
    planes[:, 6:] = np.sort(planes[:, 6:], axis=1)
    return forms, runs, triangle, weights, planes


def test_parameter_fields_agree_with_their_twin():
    forms, _, triangle, weights, _ = scattered(90)
    a, b = np.empty((90, 2), np.float32), np.empty((90, 2), np.float32)
    polymap.parameter_fields(forms, triangle, weights, a)
    polymap_twin.parameter_fields(forms, triangle, weights, b)
    np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-5)


def test_evaluation_in_runs_agrees_with_its_twin():
    """More points than a piece, and runs that go on from one piece to the next."""
    case = scattered()
    a, b = np.empty((3, 9000), np.float32), np.empty((3, 9000), np.float32)
    polymap.evaluate_runs(*case, a)
    polymap_twin.evaluate_runs(*case, b)
    np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-4)
