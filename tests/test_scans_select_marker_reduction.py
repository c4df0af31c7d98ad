"""Which markers can be spared."""

import numpy as np
import pytest
import scipy.optimize

from mien.errors import BadInput
from mien.scans.select.marker_reduction import StudyConfig, select_markers
from mien.scans.select.select_frames import SelectConfig, select_frames
from test_scans_select_select_frames import low_rank_take

SMALL = StudyConfig(least=4, sample=40)


def studied(positions, config=SMALL):
    frames = select_frames(positions, SelectConfig(tolerance=1e-9, max_frames=6)).frames
    return select_markers(positions, frames, config)


def error_with(positions, frames, kept):
    """Mean distance of all markers with weights from the kept ones, by scipy."""
    X = positions - positions.mean(axis=(0, 1))
    part = X[:, kept].reshape(len(X), -1)
    weights = np.array([scipy.optimize.nnls(part[frames].T, x)[0] for x in part])
    return np.linalg.norm(X - np.einsum("tc,cmd->tmd", weights, X[frames]), axis=2).mean()


def test_kept_markers_beat_random_ones():
    positions = low_rank_take(1, markers=16, noise=0.3)
    frames = select_frames(positions, SelectConfig(tolerance=1e-9, max_frames=6)).frames
    study = select_markers(positions, frames, SMALL)
    ours = error_with(positions, frames, study.keep(6))
    np.testing.assert_allclose(study.errors[10], ours, rtol=1e-6)
    rng = np.random.default_rng(0)
    others = [error_with(positions, frames, rng.choice(16, 6, replace=False)) for _ in range(40)]
    assert ours < np.quantile(others, 0.1)


def test_first_step_is_the_best_of_all_single_removals():
    positions = low_rank_take(2, frames=40, markers=8, noise=0.5)
    study = studied(positions, StudyConfig(least=7, sample=40))
    frames = select_frames(positions, SelectConfig(tolerance=1e-9, max_frames=6)).frames
    X = positions - positions.mean(axis=(0, 1))
    costs = []
    for m in range(8):
        kept = np.delete(np.arange(8), m)
        part = X[:, kept].reshape(40, -1)
        weights = np.array([scipy.optimize.nnls(part[frames].T, x)[0] for x in part])
        costs.append(((X - np.einsum("tc,cmd->tmd", weights, X[frames])) ** 2).sum())
    assert study.removed.tolist() == [int(np.argmin(costs))]


def test_error_grows_and_the_first_is_that_of_all_markers():
    positions = low_rank_take(3, frames=80, markers=20, noise=0.3)
    selection = select_frames(positions, SelectConfig(tolerance=1e-9, max_frames=6))
    study = select_markers(positions, selection.frames, SMALL)
    np.testing.assert_allclose(study.errors[0], selection.errors[-1], rtol=1e-6)
    assert len(study.removed) == 16
    assert study.errors[-1] > 1.05 * study.errors[0]


def test_kept_and_removed_make_all():
    study = studied(low_rank_take(4))
    assert sorted([*study.keep(7), *study.removed[: 12 - 7]]) == list(range(12))
    assert study.keep(12).tolist() == list(range(12))


def test_never_fewer_markers_than_determine_the_weights():
    positions = low_rank_take(5, markers=12)
    study = select_markers(positions, np.arange(20), StudyConfig(least=1, sample=20))
    assert 12 - len(study.removed) == 7


def test_bad_input_is_named():
    positions = low_rank_take(6)
    with pytest.raises(BadInput, match="nothing to take away"):
        select_markers(positions, np.arange(3), StudyConfig(least=12))
    with pytest.raises(BadInput, match="covers 4 to 12"):
        studied(positions).keep(3)
    positions[3, 2] = np.nan
    with pytest.raises(BadInput, match="gaps"):
        select_markers(positions, np.arange(3))
