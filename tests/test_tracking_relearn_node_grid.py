"""Nodes over a picture: sums over cells, values between nodes, and the smoothest answer to what each node says."""

import numpy as np

from mien.tracking.relearn.node_grid import NodeGrid, node_grid, solve_smoothly


def whole(h=12, w=16, node=4) -> NodeGrid:
    return node_grid(np.ones((h, w), bool), node)


def test_cells_are_summed_and_those_of_which_nothing_is_known_are_left_out():
    known = np.ones((6, 8), bool)
    known[:4, :4] = False
    grid = node_grid(known, 4)
    np.testing.assert_array_equal(grid.there, [[False, True], [True, True]])
    np.testing.assert_array_equal(grid.summed(np.ones((1, 6, 8)))[:, 0], [16, 8, 8])
    np.testing.assert_array_equal(grid.neighbours.toarray(), [[0, 0, 1], [0, 0, 1], [1, 1, 0]])


def test_values_are_linear_between_the_middles_of_cells():
    grid = whole()
    rows, columns = np.nonzero(grid.there)
    ramp = np.stack([2.0 + 4 * columns, 3.0 - 4 * rows], axis=1)
    found = grid.between(ramp)
    y, x = np.mgrid[:12, :16]
    inside = (slice(2, 10), slice(2, 14))
    np.testing.assert_allclose(found[0][inside], (2.0 + x - 1.5)[inside], atol=1e-5)
    np.testing.assert_allclose(found[1][inside], (3.0 - y + 1.5)[inside], atol=1e-5)


def test_a_node_that_speaks_is_heard_by_all_that_are_linked_to_it():
    """One node says 3, with whatever weight, the others nothing: the smoothest answer is 3 everywhere."""
    grid = whole()
    n = int(grid.there.sum())
    A, b = np.zeros((n, 2, 2)), np.zeros((n, 2))
    A[5], b[5] = 0.1 * np.eye(2), 0.1 * np.array([3.0, -1.0])
    found = solve_smoothly(grid, A, b, np.zeros((n, 2)), smoothness=1.0, small=0.0)
    np.testing.assert_allclose(found, np.broadcast_to([3.0, -1.0], (n, 2)), rtol=0.02)


def test_the_answer_is_the_least_squares_one():
    rng, grid = np.random.default_rng(0), whole(8, 12)
    n, m = int(grid.there.sum()), 3
    half = rng.normal(size=(n, m, m))
    A, b = half @ np.swapaxes(half, 1, 2), rng.normal(size=(n, m))
    found = solve_smoothly(grid, A, b, np.zeros((n, m)), smoothness=2.0, small=0.5)
    L = np.diag(np.asarray(grid.neighbours.sum(axis=1)).ravel()) - grid.neighbours.toarray()
    full = np.kron(2.0 * L + 0.5 * np.eye(n), np.eye(m))
    for i in range(n):
        full[i * m : i * m + m, i * m : i * m + m] += A[i]
    np.testing.assert_allclose(found.ravel(), np.linalg.solve(full, b.ravel()), atol=5e-3)


def test_pooled_sums_keep_the_total_far_from_the_border():
    grid = whole(80, 80)
    values = np.zeros((int(grid.there.sum()), 1))
    values[210] = 5.0
    pooled = grid.pooled(values, sigma=8.0)
    np.testing.assert_allclose(pooled.sum(), 5.0, rtol=1e-3)
    assert pooled.argmax() == 210
