"""Box-constrained least squares."""

from inspect import unwrap

import numpy as np
import pytest
import scipy.optimize

from mien.solve import box_least_squares


def problem(seed, frames=60, rows=40, columns=15):
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(rows, columns)) * np.logspace(0, -1.5, columns)
    truth = rng.uniform(-0.5, 1.5, (frames, columns))
    return matrix, truth @ matrix.T + 0.1 * rng.normal(size=(frames, rows))


def test_one_variable_by_hand():
    # 1/2 4 w^2 - b w + 1 w: the minimum is at (b - 1) / 4, cut to [0.5, 2]
    found = box_least_squares(np.array([[4.0]]), np.array([[5.0], [1.0], [20.0]]), lower=0.5, upper=2.0, l1=1.0)
    np.testing.assert_allclose(found.values, [[1.0], [0.5], [2.0]])


@pytest.mark.parametrize(("lower", "upper"), [(0.0, 1.0), (-1.0, 0.3), (-np.inf, 0.4), (-np.inf, np.inf)])
def test_equals_scipy(lower, upper):
    matrix, data = problem(1)
    found = box_least_squares(matrix.T @ matrix, data @ matrix, lower, upper)
    bounds = (lower, upper)
    expected = [scipy.optimize.lsq_linear(matrix, x, bounds, method="bvls", tol=1e-14).x for x in data]
    np.testing.assert_allclose(found.values, expected, atol=1e-8)
    assert found.converged.all()


def test_bounds_of_each_variable_and_a_fixed_one():
    matrix, data = problem(2)
    lower, upper = np.linspace(-1, 0.2, 15), np.linspace(0.2, 1, 15)
    lower[4] = upper[4] = 0.7
    w = box_least_squares(matrix.T @ matrix, data @ matrix, lower, upper).values
    assert (w >= lower).all()
    assert (w <= upper).all()
    np.testing.assert_array_equal(w[:, 4], 0.7)


def test_l1_is_a_linear_term_above_zero():
    matrix, data = problem(3)
    gram, linear = matrix.T @ matrix, data @ matrix
    l1 = np.linspace(0, 2, 15)
    found = box_least_squares(gram, linear, l1=l1)
    np.testing.assert_allclose(found.values, box_least_squares(gram, linear - l1).values, atol=1e-12)
    assert (found.values == 0).sum() > (box_least_squares(gram, linear).values == 0).sum()


def test_an_l1_term_on_dependent_columns_slides_to_a_bound():
    # column 2 = column 0 + column 1: with l1 the sum is cheaper than its parts
    matrix = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    start = np.array([[0.4, 0.4, 0.2]])
    found = box_least_squares(matrix.T @ matrix, np.array([[0.8, 0.8]]) @ matrix, l1=0.1, warm=start)
    np.testing.assert_allclose(found.values, [[0.0, 0.0, 0.75]], atol=1e-12)
    assert found.converged.all()


def test_a_gram_for_every_frame_equals_one_by_one():
    rng = np.random.default_rng(4)
    matrices, data = rng.normal(size=(50, 20, 6)), rng.normal(size=(50, 20))
    grams, linear = np.einsum("tri,trj->tij", matrices, matrices), np.einsum("tri,tr->ti", matrices, data)
    together = box_least_squares(grams, linear, 0.0, 0.2)
    alone = [box_least_squares(gram, b[None], 0.0, 0.2).values[0] for gram, b in zip(grams, linear, strict=True)]
    np.testing.assert_allclose(together.values, alone, atol=1e-12)


def test_where_it_starts_does_not_matter():
    matrix, data = problem(5)
    gram, linear = matrix.T @ matrix, data @ matrix
    cold = box_least_squares(gram, linear)
    warm = box_least_squares(gram, linear, warm=np.random.default_rng(0).uniform(-1, 2, linear.shape))
    np.testing.assert_allclose(warm.values, cold.values, atol=1e-9)


def test_the_stated_breach_is_that_of_the_definition():
    matrix, data = problem(6)
    gram, linear = matrix.T @ matrix, data @ matrix
    found = box_least_squares(gram, linear)
    down = linear - found.values @ gram
    off = np.where(((down > 0) & (found.values < 1)) | ((down < 0) & (found.values > 0)), np.abs(down), 0).max(1)
    assert (off <= 1e-10 * np.abs(linear).max(1)).all()
    assert found.breach.max() <= 1e-10


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lower": 1.0, "upper": 0.0}, "bounds: expected lower <= upper"),
        ({"upper": np.nan}, "bounds: expected lower <= upper"),
        ({"lower": -1.0, "l1": 0.1}, "l1: expected lower bounds >= 0"),
        ({"l1": -0.1}, "l1: expected >= 0"),
    ],
)
def test_wrong_bounds_and_weights_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        box_least_squares(np.eye(2), np.zeros((3, 2)), **arguments)


@pytest.mark.parametrize(
    ("gram", "linear", "warm", "message"),
    [
        (np.eye(3), np.zeros((4, 2)), None, "gram: expected"),
        (np.zeros((3, 2, 2)), np.zeros((4, 2)), None, "gram: expected"),
        (np.eye(2), np.full((4, 2), np.nan), None, "finite"),
        (np.eye(2), np.zeros((4, 2)), np.zeros((3, 2)), "warm: expected"),
    ],
)
def test_wrong_sizes_and_nan_are_named(gram, linear, warm, message):
    with pytest.raises(ValueError, match=message):
        unwrap(box_least_squares)(gram, linear, warm=warm)
