"""Kernels of the selection agree with their numpy twins."""

import numpy as np
import pytest

from mien._kernels import select, select_twin


def problem(seed, frames=24, chosen=5, candidates=21, length=12):
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(frames, length)) + 4.0
    basis, tried = rows[:chosen], rows[rng.integers(chosen, frames, candidates)] + 0.1 * rng.normal(size=length)
    state = select.restate(basis @ basis.T, rows @ basis.T, np.zeros((frames, chosen)))
    residuals = rows - state[0] @ basis
    orthonormal = np.linalg.qr(basis.T)[0]
    apart = (tried**2).sum(1) - ((tried @ orthonormal) ** 2).sum(1)
    errors = (residuals**2).sum(1)
    arguments = (
        tried @ residuals.T, tried @ basis.T, (tried**2).sum(1), apart, np.argsort(-errors), errors,
        float((rows**2).sum(1).max()), basis @ basis.T, *state,
    )  # fmt: skip
    return rows, basis, tried, arguments


def test_restate_equals_its_twin():
    rng = np.random.default_rng(0)
    basis, rows = rng.normal(size=(6, 10)), rng.normal(size=(70, 10))
    start = np.maximum(rng.normal(size=(70, 6)), 0)
    kernel = select.restate(basis @ basis.T, rows @ basis.T, start)
    twin = select_twin.restate(basis @ basis.T, rows @ basis.T, start)
    for found, expected in zip(kernel, twin, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_weigh_gives_the_exact_gain_or_proves_that_it_falls_short(seed):
    rows, basis, tried, arguments = problem(seed)
    expected = select_twin.weigh(rows, basis, tried)
    for best in (0.0, float(np.median(expected)), float(expected.max())):
        gains = select.weigh(*arguments, best * (1 - 1e-9))
        known = gains >= 0
        np.testing.assert_allclose(gains[known], expected[known], rtol=1e-7)
        assert (expected[~known] <= max(best, gains.max()) * (1 + 1e-9)).all()
        assert known[np.argmax(expected)]


@pytest.mark.parametrize("seed", range(3))
def test_ceilings_are_never_below_the_exact_gain(seed):
    rows, basis, tried, arguments = problem(seed)
    bounds, squares = select.ceilings(arguments[0], arguments[3], arguments[5])
    assert (bounds >= select_twin.weigh(rows, basis, tried) * (1 - 1e-9)).all()
    np.testing.assert_allclose(squares, (np.maximum(arguments[0], 0) ** 2).sum(axis=1))


def test_residual_products_equal_their_definition():
    rng = np.random.default_rng(3)
    rows, weights = rng.normal(size=(30, 8)), rng.random((30, 4))
    residuals = rows - weights @ rows[:4]
    found = select.residual_products(rows @ rows.T, rows @ rows[:4].T, weights.T.copy(), np.array([5, 29]))
    np.testing.assert_allclose(found, rows[[5, 29]] @ residuals.T, atol=1e-12)
