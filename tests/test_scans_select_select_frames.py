"""Greedy selection of the frames to scan."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.optimize

from mien.errors import BadInput
from mien.scans.select.select_frames import SelectConfig, select_frames, strongest_frames

EVERYTHING = SelectConfig(tolerance=1e-9, max_frames=8)


def low_rank_take(seed, frames=60, markers=12, shapes=7, noise=0.05):
    rng = np.random.default_rng(seed)
    rest = rng.uniform(-70, 70, (markers, 3))
    deltas = rng.normal(size=(shapes, markers, 3)) * rng.uniform(1, 6, (shapes, 1, 1))
    weights = np.clip(rng.normal(0.1, 0.5, (frames, shapes)), 0, 1)
    return rest + np.einsum("ts,smd->tmd", weights, deltas) + noise * rng.normal(size=(frames, markers, 3))


def brute_force(positions, count):
    """Algorithm 1 as it is printed, with scipy's solver: frames, and the sum of squares after each."""
    X = (positions - positions.mean(axis=(0, 1))).reshape(len(positions), -1)

    def error(chosen):
        return sum(scipy.optimize.nnls(X[chosen].T, x)[1] ** 2 for x in X)

    chosen, errors = [], []
    for _ in range(count):
        tried = {t: error([*chosen, t]) for t in range(len(X)) if t not in chosen}
        chosen.append(min(tried, key=tried.get))
        errors.append(tried[chosen[-1]])
    return chosen, errors


def residuals(positions, selection):
    X = positions - selection.origin
    return X - np.einsum("tc,cmd->tmd", selection.weights, X[selection.frames])


@pytest.mark.parametrize("seed", range(3))
def test_equals_brute_force(seed):
    positions = low_rank_take(seed, frames=36)
    selection = select_frames(positions, SelectConfig(tolerance=1e-9, max_frames=6))
    frames, errors = brute_force(positions, 6)
    assert selection.frames.tolist() == frames
    np.testing.assert_allclose((residuals(positions, selection) ** 2).sum(), errors[-1], rtol=1e-9)


def test_equals_brute_force_with_fewer_coordinates_than_frames_chosen():
    positions = low_rank_take(9, frames=40, markers=2, shapes=4)
    selection = select_frames(positions, SelectConfig(tolerance=1e-12, max_frames=5))
    frames, errors = brute_force(positions, len(selection.frames))
    np.testing.assert_allclose((residuals(positions, selection) ** 2).sum(), errors[-1], rtol=1e-6, atol=1e-6)
    assert selection.frames.tolist()[:3] == frames[:3]


def calm_take_with_an_outburst():
    """Ninety frames that hardly move, ten of five strong shapes, two each."""
    rng = np.random.default_rng(3)
    deltas = rng.normal(size=(5, 12, 3)) * 5
    weights = np.zeros((100, 5))
    weights[90 + np.arange(10), np.arange(10) // 2] = [1.0, 0.7] * 5
    return (
        rng.uniform(-70, 70, (12, 3)) + np.einsum("ts,smd->tmd", weights, deltas) + 0.02 * rng.normal(size=(100, 12, 3))
    )


def test_calm_frames_do_not_hide_the_strongest_tenth():
    """By the mean alone, as in the paper, few frames do; the strongest tenth asks for every shape."""
    positions = calm_take_with_an_outburst()
    alone = select_frames(positions, SelectConfig(strongest=np.inf))
    both = select_frames(positions)
    assert alone.reached
    assert both.reached
    assert len(alone.frames) < len(both.frames)
    assert alone.frames.tolist() == both.frames[: len(alone.frames)].tolist()
    assert alone.strongest[-1] > 0.15 > 0.12 > both.strongest[-1]
    strong, moved = strongest_frames(positions)
    assert sorted(strong.tolist()) == list(range(90, 100))
    left = np.linalg.norm(residuals(positions, both), axis=2)[strong].mean()
    np.testing.assert_allclose(both.strongest[-1], left / moved)


def test_weights_meet_the_optimality_conditions_of_every_frame():
    positions = low_rank_take(5)
    selection = select_frames(positions, EVERYTHING)
    basis = (positions - selection.origin)[selection.frames].reshape(8, -1)
    slope = residuals(positions, selection).reshape(60, -1) @ basis.T
    scale = (basis**2).sum(axis=1).max()
    assert (selection.weights >= 0).all()
    assert slope.max() < 1e-9 * scale
    np.testing.assert_allclose(slope[selection.weights > 0], 0, atol=1e-9 * scale)


def test_pure_mixes_of_three_faces_need_those_three_after_the_most_typical_one():
    rng = np.random.default_rng(6)
    corners = rng.uniform(-70, 70, (3, 20, 3))
    mixes = np.vstack([np.eye(3), rng.dirichlet([1, 1, 1], 40)])
    selection = select_frames(np.einsum("tc,cmd->tmd", mixes, corners), SelectConfig(tolerance=1e-7))
    assert selection.frames[0] > 2
    assert sorted(selection.frames.tolist()[1:]) == [0, 1, 2]
    assert selection.reached


def test_errors_are_the_mean_distance_and_fall():
    positions = low_rank_take(7)
    selection = select_frames(positions, EVERYTHING)
    distance = np.linalg.norm(residuals(positions, selection), axis=2).mean()
    np.testing.assert_allclose(selection.errors[-1], distance, rtol=1e-9)
    assert all(a > b for a, b in pairwise(selection.errors))
    corner = positions.reshape(-1, 3)
    np.testing.assert_allclose(selection.diagonal, np.linalg.norm(corner.max(0) - corner.min(0)))


def test_stops_at_the_tolerance():
    positions = low_rank_take(8)
    full = select_frames(positions, EVERYTHING)
    tolerance = float(full.relative[3:5].mean())
    short = select_frames(positions, SelectConfig(tolerance=tolerance, strongest=np.inf))
    assert short.frames.tolist() == full.frames.tolist()[:5]
    assert short.reached
    assert not full.reached


def test_neither_units_nor_the_place_in_the_lab_matter():
    positions = low_rank_take(10)
    here = select_frames(positions, EVERYTHING)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    there = select_frames(25.4 * (positions @ turn.T + [300.0, -900.0, 50.0]), EVERYTHING)
    assert here.frames.tolist() == there.frames.tolist()
    np.testing.assert_allclose(there.weights, here.weights, atol=1e-7)


def test_a_take_longer_than_the_table_of_inner_products_gives_the_same(monkeypatch):
    positions = low_rank_take(11, frames=90)
    expected = select_frames(positions, EVERYTHING)
    monkeypatch.setattr("mien.scans.select.select_frames.INNER_FRAMES", 10)
    np.testing.assert_array_equal(select_frames(positions, EVERYTHING).frames, expected.frames)


def test_a_frame_that_stands_twice_is_chosen_once_and_first():
    positions = low_rank_take(12, frames=30)
    doubled = np.vstack([positions, positions])
    one, two = select_frames(positions, EVERYTHING), select_frames(doubled, EVERYTHING)
    np.testing.assert_array_equal(two.frames % 30, one.frames)


@pytest.mark.parametrize(
    ("frames", "markers"),
    [(2, 1), (3, 2), (7, 5)],
)
def test_small_takes_end_by_themselves(frames, markers):
    positions = np.random.default_rng(1).normal(size=(frames, markers, 3))
    selection = select_frames(positions, SelectConfig(tolerance=1e-9))
    assert len(set(selection.frames.tolist())) == len(selection.frames) <= frames
    assert selection.errors[-1] < 1e-6 or len(selection.frames) == frames


def test_progress_is_told():
    told = []

    class Listener:
        def update(self, stage, done, total):
            told.append((stage, done, total))

    select_frames(low_rank_take(0), SelectConfig(tolerance=1e-9, max_frames=3), Listener())
    assert [done for _, done, _ in told] == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("positions", "config", "message"),
    [
        (np.full((5, 3, 3), np.nan), SelectConfig(), "marker 0 is missing in frame 0"),
        (np.zeros((1, 3, 3)), SelectConfig(), "1 frames and 3 markers"),
        (np.zeros((5, 0, 3)), SelectConfig(), "5 frames and 0 markers"),
        (np.ones((5, 3, 3)), SelectConfig(), "one point"),
        (np.random.default_rng(0).normal(size=(5, 3, 3)), SelectConfig(tolerance=0.0), "tolerance"),
        (np.random.default_rng(0).normal(size=(5, 3, 3)), SelectConfig(max_frames=0), "max_frames"),
    ],
)
def test_bad_input_is_named(positions, config, message):
    with pytest.raises(BadInput, match=message):
        select_frames(positions, config)
