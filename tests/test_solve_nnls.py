"""Non-negative least squares."""

import numpy as np
import pytest
import scipy.optimize

from mien.solve import nnls


def problems(rng, frames, rows, columns):
    matrix = rng.normal(size=(rows, columns))
    return matrix, rng.normal(size=(frames, rows)) @ np.diag(rng.uniform(0.1, 3, rows))


def test_one_variable_by_hand():
    result = nnls(np.array([[2.0]]), np.array([[3.0], [-1.0]]))
    np.testing.assert_allclose(result.values, [[1.5], [0.0]])
    assert result.converged.all()


@pytest.mark.parametrize("columns", [1, 3, 20])
def test_equals_scipy(columns):
    matrix, data = problems(np.random.default_rng(columns), frames=70, rows=30, columns=columns)
    result = nnls(matrix.T @ matrix, data @ matrix)
    expected = np.array([scipy.optimize.nnls(matrix, x)[0] for x in data])
    np.testing.assert_allclose(result.values, expected, atol=1e-9)
    assert result.converged.all()


def test_optimality_conditions():
    matrix, data = problems(np.random.default_rng(5), frames=200, rows=60, columns=40)
    gram, linear = matrix.T @ matrix, data @ matrix
    w = nnls(gram, linear).values
    gradient = w @ gram - linear
    assert (w >= 0).all()
    assert gradient.min() > -1e-8 * np.abs(linear).max()
    np.testing.assert_allclose(np.where(w > 0, gradient, 0), 0, atol=1e-8 * np.abs(linear).max())


def test_a_gram_for_every_frame():
    rng = np.random.default_rng(6)
    matrices, data = rng.normal(size=(40, 15, 8)), rng.normal(size=(40, 15))
    grams = np.einsum("tri,trj->tij", matrices, matrices)
    result = nnls(grams, np.einsum("tri,tr->ti", matrices, data))
    expected = [scipy.optimize.nnls(matrix, x)[0] for matrix, x in zip(matrices, data, strict=True)]
    np.testing.assert_allclose(result.values, expected, atol=1e-9)


def test_duplicate_and_dependent_columns_reach_the_same_error():
    rng = np.random.default_rng(7)
    matrix, data = problems(rng, frames=100, rows=40, columns=12)
    doubled = np.hstack([matrix, matrix[:, :6], matrix[:, :3] + matrix[:, 3:6], np.zeros((40, 1))])
    result = nnls(doubled.T @ doubled, data @ doubled)
    assert result.converged.all()
    reached = np.linalg.norm(result.values @ doubled.T - data, axis=1)
    expected = [scipy.optimize.nnls(matrix, x)[1] for x in data]
    np.testing.assert_allclose(reached, expected, rtol=1e-9)


def test_starting_at_the_answer_takes_no_steps():
    matrix, data = problems(np.random.default_rng(8), frames=50, rows=30, columns=10)
    gram, linear = matrix.T @ matrix, data @ matrix
    cold = nnls(gram, linear)
    warm = nnls(gram, linear, warm=cold.values)
    np.testing.assert_allclose(warm.values, cold.values, atol=1e-10)
    assert warm.iterations.max() == 0
    assert cold.iterations.max() > 0
