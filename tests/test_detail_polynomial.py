import numpy as np
import pytest

from mien.detail.polynomial import EXPONENTS, PolynomialConfig, PolynomialFit, exponents
from mien.errors import BadInput


def fitted(order, frames=40, config=None, truth_order=None, noise=0.0):
    rng = np.random.default_rng(1)
    truth = rng.normal(size=(7, len(EXPONENTS[truth_order or order]), 3))
    fit = PolynomialFit(7, 3, config or PolynomialConfig(order, 0.0))
    for _ in range(frames):
        d = rng.normal(size=(7, 2))
        powers = (d[:, None, :] ** EXPONENTS[truth_order or order][None]).prod(axis=2)
        fit.add(d, np.einsum("pm,pmc->pc", powers, truth) + noise * rng.normal(size=(7, 3)))
    return truth, fit


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_polynomial_is_found_again(order):
    truth, fit = fitted(order)
    found = fit.solve()
    np.testing.assert_allclose(found.coefficients, truth, atol=1e-5)
    np.testing.assert_allclose(fit.rms(found), 0, atol=1e-3)


def test_the_whole_deformation_takes_the_place_of_linear_terms():
    """By hand, order 2: three products of d1 and d2, the five entries, and 1."""
    d1, d2, *entries = values = np.array([2.0, 3.0, 5, 7, 11, 13, 17])
    found = (values ** exponents(2, whole_deformation=True)).prod(axis=1)
    np.testing.assert_array_equal(found, [d1**2, d2**2, d1 * d2, *entries, 1])


def test_rms_is_what_the_map_leaves():
    truth, fit = fitted(1, truth_order=2)
    rng = np.random.default_rng(1)
    rng.normal(size=truth.shape)
    found, left = fit.solve(), []
    for _ in range(40):
        d = rng.normal(size=(7, 2))
        powers = (d[:, None, :] ** EXPONENTS[2][None]).prod(axis=2)
        exact = np.einsum("pm,pmc->pc", powers, truth)
        rng.normal(size=(7, 3))
        left.append(((exact - found.evaluate(d.astype(np.float32))) ** 2).sum(axis=1))
    np.testing.assert_allclose(fit.rms(found), np.sqrt(np.mean(left, axis=0)), rtol=1e-3)


def test_regularisation_holds_a_parameter_that_never_varied():
    """By hand: d2 = 0 in every frame, so its coefficients are free; the ridge alone sets them, to 0."""
    fit = PolynomialFit(1, 1, PolynomialConfig(2, 0.01))
    for d1 in np.linspace(-1, 1, 9):
        fit.add(np.array([[d1, 0.0]]), np.array([[2 * d1 + 1]]))
    a = fit.solve().coefficients[0, :, 0]
    np.testing.assert_allclose(a, [0, 0, 0, 2, 0, 1], atol=1e-3)


def test_regularisation_is_free_of_units():
    """Parameters in another unit: the same predictions."""
    out = []
    for unit in (1.0, 1000.0):
        rng, fit = np.random.default_rng(2), PolynomialFit(1, 1, PolynomialConfig(2, 0.3))
        for _ in range(20):
            d = rng.normal(size=(1, 2))
            fit.add(unit * d, d[:, :1] ** 2 + d[:, 1:])
        out.append(fit.solve().evaluate(np.array([[unit * 0.7, unit * -0.4]], np.float32)))
    np.testing.assert_allclose(out[0], out[1], rtol=1e-4)


def test_a_texel_that_no_frame_shows_is_marked_and_finite():
    fit = PolynomialFit(2, 1)
    for d in (0.0, 1.0, 2.0):
        fit.add(np.full((2, 2), d), np.array([[d], [np.nan]]))
    found = fit.solve()
    assert found.seen.tolist() == [True, False]
    assert np.isfinite(found.coefficients).all()
    assert np.isnan(fit.rms(found)[1])


def test_one_frame_and_strange_orders_are_refused():
    fit = PolynomialFit(1, 1)
    fit.add(np.zeros((1, 2)), np.zeros((1, 1)))
    with pytest.raises(BadInput, match="at least 2"):
        fit.solve()
    with pytest.raises(BadInput, match="order is 4"):
        PolynomialConfig(order=4)
