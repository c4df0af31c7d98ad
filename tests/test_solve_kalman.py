"""The Kalman filter bank."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from mien.solve import kalman
from mien.solve.kalman import KalmanConfig

CONFIG = KalmanConfig()
DT = 1 / 30


def run(measurements, dt=DT, config=CONFIG):
    state = kalman.start(measurements[0], config)
    states = [state]
    for z in measurements[1:]:
        state = kalman.step(state, z, dt, config)
        states.append(state)
    return states


def test_steady_state_solves_the_riccati_equation():
    final = run(np.zeros((300, 1)))[-1]
    advance = np.array([[1, DT], [0, 1]])
    q = (CONFIG.process * CONFIG.rate) ** 2 * CONFIG.rate
    noise = q * np.array([[DT**3 / 3, DT**2 / 2], [DT**2 / 2, DT]])
    predicted = solve_discrete_are(advance.T, np.array([[1.0], [0.0]]), noise, np.array([[CONFIG.measurement**2]]))
    gain = predicted[:, 0] / (predicted[0, 0] + CONFIG.measurement**2)
    np.testing.assert_allclose(final.covariance[0], predicted - np.outer(gain, predicted[0]), rtol=1e-8)


def test_a_straight_line_is_followed_exactly():
    t = np.arange(200) * DT
    final = run(np.stack([0.3 * t, 1 - 0.1 * t], axis=1))[-1]
    np.testing.assert_allclose(final.mean, [[0.3 * t[-1], 0.3], [1 - 0.1 * t[-1], -0.1]], atol=1e-9)


def test_noise_falls_and_more_so_the_calmer_the_process():
    noise = CONFIG.measurement * np.random.default_rng(0).normal(size=(400, 40))
    left = [
        np.std([s.values for s in run(noise, config=KalmanConfig(process=p))][100:]) / CONFIG.measurement
        for p in (0.05, 0.005, 0.0005)
    ]
    assert 1 > left[0] > left[1] > left[2]
    assert left[2] < 0.5


def test_predicted_variance_is_the_one_observed():
    rng = np.random.default_rng(1)
    q = (CONFIG.process * CONFIG.rate) ** 2 * CONFIG.rate
    noise = np.linalg.cholesky(q * np.array([[DT**3 / 3, DT**2 / 2], [DT**2 / 2, DT]]))
    truth = np.zeros((200, 2000, 2))
    for i in range(1, 200):
        truth[i] = truth[i - 1] @ np.array([[1, DT], [0, 1]]).T + rng.normal(size=(2000, 2)) @ noise.T
    states = run(truth[:, :, 0] + CONFIG.measurement * rng.normal(size=(200, 2000)))
    errors = np.concatenate([s.values - x[:, 0] for s, x in zip(states[50:], truth[50:], strict=True)])
    np.testing.assert_allclose(np.var(errors), states[-1].covariance[0, 0, 0], rtol=0.03)


def test_an_unseen_coefficient_coasts_and_grows_unsure():
    state = run(np.stack([np.arange(50) * 0.01] * 2, axis=1))[-1]
    after = kalman.step(state, np.array([np.nan, 0.5]), DT)
    np.testing.assert_allclose(after.values[0], state.values[0] + DT * state.mean[0, 1])
    assert after.covariance[0, 0, 0] > after.covariance[1, 0, 0]


def test_two_half_predictions_are_one():
    state = run(np.random.default_rng(2).normal(size=(20, 3)))[-1]
    unseen = np.full(3, np.nan)
    halves = kalman.step(kalman.step(state, unseen, DT / 2), unseen, DT / 2)
    whole = kalman.step(state, unseen, DT)
    np.testing.assert_allclose(halves.mean, whole.mean)
    np.testing.assert_allclose(halves.covariance, whole.covariance)


def test_the_state_that_went_in_is_left_alone():
    state = kalman.start(np.zeros(2))
    before = state.mean.copy(), state.covariance.copy()
    kalman.step(state, np.ones(2), DT)
    np.testing.assert_array_equal(state.mean, before[0])
    np.testing.assert_array_equal(state.covariance, before[1])


def test_wrong_intervals_and_lengths_are_named():
    with pytest.raises(ValueError, match="dt: expected > 0"):
        kalman.step(kalman.start(np.zeros(2)), np.zeros(2), 0.0)
    with pytest.raises(ValueError, match="measurement: expected shape"):
        kalman.step(kalman.start(np.zeros(2)), np.zeros(3), DT)
