"""Box-constrained least squares that is smooth in time."""

from inspect import unwrap

import numpy as np
import pytest
import scipy.optimize

from mien.solve import box_least_squares, smooth_box_least_squares
from mien.solve.smooth import time_links


def problem(seed, frames=40, rows=30, columns=6):
    rng = np.random.default_rng(seed)
    matrices = rng.normal(size=(frames, rows, columns)) * (rng.random((frames, rows, 1)) > 0.3)
    phase = rng.uniform(0, 6, columns)
    truth = 0.5 + 0.8 * np.sin(np.arange(frames)[:, None] / 6 + phase)
    data = np.einsum("trk,tk->tr", matrices, truth) + 0.5 * rng.normal(size=(frames, rows))
    grams = np.einsum("tri,trj->tij", matrices, matrices)
    return grams, np.einsum("tri,tr->ti", matrices, data)


def cost(w, grams, linear, l1, mu, nu):
    own = 0.5 * np.einsum("ti,tij,tj", w, grams, w) - np.vdot(linear, w) + l1 * np.abs(w).sum()
    return own + mu / 2 * (np.diff(w, axis=0) ** 2).sum() + nu / 2 * (np.diff(w, 2, axis=0) ** 2).sum()


def test_two_frames_by_hand():
    # 1/2 (w0 - 1)^2 + 1/2 (w1 - 0)^2 + 1/2 (w1 - w0)^2 has its minimum at (2/3, 1/3)
    found = smooth_box_least_squares(np.eye(1), np.array([[1.0], [0.0]]), mu=1.0)
    np.testing.assert_allclose(found.values, [[2 / 3], [1 / 3]], atol=1e-9)


@pytest.mark.parametrize(("mu", "nu"), [(3.0, 0.0), (0.0, 20.0), (2.0, 5.0)])
def test_no_worse_than_a_general_minimiser(mu, nu):
    grams, linear = problem(1)
    found = smooth_box_least_squares(grams, linear, 0.0, 1.0, 0.3, mu, nu)
    assert found.converged.all()
    assert found.values.min() >= 0
    assert found.values.max() <= 1
    flat = found.values.ravel()

    def total(w):
        return cost(w.reshape(linear.shape), grams, linear, 0.3, mu, nu)

    rough = scipy.optimize.minimize(total, np.full(flat.size, 0.5), method="L-BFGS-B", bounds=[(0, 1)] * flat.size)
    assert total(flat) <= rough.fun + 1e-9 * abs(rough.fun)
    np.testing.assert_allclose(flat, rough.x, atol=2e-2)


@pytest.mark.parametrize(("mu", "nu"), [(1.0, 0.0), (0.0, 1.0), (50.0, 0.1)])
def test_slope_of_the_cost_meets_the_stated_breach(mu, nu):
    grams, linear = problem(2)
    found = smooth_box_least_squares(grams, linear, l1=0.1, mu=mu, nu=nu)
    w = found.values
    dense = np.zeros((40, 6, 40, 6))
    first, second = np.diff(np.eye(40), axis=0), np.diff(np.eye(40), 2, axis=0)
    for i in range(6):
        dense[:, i, :, i] = mu * first.T @ first + nu * second.T @ second
    for t in range(40):
        dense[t, :, t] += grams[t]
    down = linear - 0.1 - np.einsum("sitj,tj->si", dense, w)
    off = np.where(((down > 0) & (w < 1)) | ((down < 0) & (w > 0)), np.abs(down), 0)
    assert off.max() <= 1e-8 * np.abs(linear).max()


def test_links_are_the_products_of_differences():
    links = time_links(9, 2.0, 3.0)
    first, second = np.diff(np.eye(9), axis=0), np.diff(np.eye(9), 2, axis=0)
    expected = 2.0 * first.T @ first + 3.0 * second.T @ second
    for d in range(3):
        np.testing.assert_allclose(links[d, : 9 - d], np.diagonal(expected, d))


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_short_takes(frames):
    grams, linear = problem(3)
    found = smooth_box_least_squares(grams[:frames], linear[:frames], mu=1.0, nu=1.0)
    assert found.converged.all()
    if frames == 1:
        np.testing.assert_allclose(found.values, box_least_squares(grams[:1], linear[:1]).values, atol=1e-7)


def test_without_smoothness_frames_stand_alone():
    grams, linear = problem(4)
    np.testing.assert_array_equal(
        smooth_box_least_squares(grams, linear).values, box_least_squares(grams, linear).values
    )


def test_frames_that_saw_nothing_are_bridged_by_their_neighbours():
    gram = np.repeat(np.eye(2)[None], 5, axis=0)
    linear = np.repeat([[0.2], [0], [0], [0], [0.6]], 2, axis=1)
    gram[1:4] = 0
    found = smooth_box_least_squares(1e6 * gram, 1e6 * linear, mu=1.0)
    np.testing.assert_allclose(found.values[:, 0], [0.2, 0.3, 0.4, 0.5, 0.6], atol=1e-5)


def test_where_it_starts_does_not_matter():
    grams, linear = problem(5)
    one = smooth_box_least_squares(grams, linear, mu=2.0, warm=np.zeros(linear.shape))
    other = smooth_box_least_squares(grams, linear, mu=2.0, warm=np.ones(linear.shape))
    np.testing.assert_allclose(one.values, other.values, atol=1e-7)


def test_negative_weights_and_wrong_starts_are_named():
    with pytest.raises(ValueError, match="mu, nu: expected >= 0"):
        smooth_box_least_squares(np.eye(2), np.zeros((3, 2)), mu=-1.0)
    with pytest.raises(ValueError, match="warm: expected"):
        unwrap(smooth_box_least_squares)(np.eye(2), np.zeros((3, 2)), mu=1.0, warm=np.zeros((2, 2)))
