"""Cross-validation over markers."""

from dataclasses import replace

import numpy as np

from marker_stage import acted, small_model
from mien.markers.left_out import (
    LeftOutConfig,
    LeftOutError,
    folds,
    jitter_of,
    leave_markers_out,
    left_out_doubt,
    neutral_leaves_open,
)
from mien.takes.frame_solve import SolveConfig
from mien.takes.motion_covariance import MotionCovariance
from mien.transforms import Transform

LOOSE = SolveConfig(sparsity=0.0, ridge=1e-6, still_power=0.0)


def test_a_model_that_is_true_tells_markers_that_it_was_not_shown():
    _, T, X = acted()
    assert leave_markers_out(small_model(), X, T, solve=LOOSE).left_out_mm < 0.05


def test_a_model_that_is_wrong_does_not_however_small_its_residual():
    _, T, X = acted()
    rng = np.random.default_rng(1)
    wrong = replace(small_model(), shapes=small_model().shapes + rng.normal(size=(6, 40, 3)) * 2)
    assert leave_markers_out(wrong, X, T, solve=LOOSE).left_out_mm > 0.5


def test_it_can_be_left_undone_and_gaps_are_no_error():
    _, T, X = acted()
    assert np.isnan(leave_markers_out(small_model(), X, T, config=LeftOutConfig(frames=0)).left_out_mm)
    holed = X.copy()
    holed[::3, 5] = np.nan
    assert leave_markers_out(small_model(), holed, T, solve=LOOSE).left_out_mm < 0.05


def test_every_group_is_spread_over_the_face():
    places = np.random.default_rng(2).normal(size=(40, 3))
    group = folds(places, 4)
    assert np.bincount(group).tolist() == [10, 10, 10, 10]
    assert all(np.ptp(places[group == g, 1]) > 0.5 * np.ptp(places[:, 1]) for g in range(4))


def test_badly_told_markers_are_a_warning_and_untried_ones_none():
    assert "82%" in left_out_doubt(LeftOutError(0.7, 0.82))[0]
    assert left_out_doubt(LeftOutError(0.4, 0.34)) == ()
    assert left_out_doubt(LeftOutError(np.nan, np.nan)) == ()


def test_what_the_neutral_leaves_open_counts_beside_the_markers_and_is_a_warning():
    """Markers told to 30 %; 4 % of squared motion is taken away, a share of 0.2 that counts twice: 50 %."""
    told = LeftOutError(0.6, 0.3, open_share=neutral_leaves_open(0.96))
    np.testing.assert_allclose(told.expected_share, 0.5)
    assert "(30% of a frozen face's error, 50% with" in str(told)
    assert left_out_doubt(told) == ()
    assert "--neutral" in left_out_doubt(replace(told, open_share=neutral_leaves_open(0.8)))[0]
    assert neutral_leaves_open(1.0) == neutral_leaves_open(0.8, LeftOutConfig(taken_away=0.0)) == 0


def test_motion_carried_from_the_markers_shown_counts_where_shapes_are_wrong():
    """A face whose shapes say nothing of the take: the others' motion still tells a hidden marker."""
    _, T, X = acted()
    rng = np.random.default_rng(1)
    wrong = replace(small_model(), shapes=rng.normal(size=(6, 40, 3)))
    flat = small_model().shapes.reshape(6, -1)
    known = (flat.T @ flat).reshape(40, 3, 40, 3)
    covariance = MotionCovariance(known, known, 0.1)
    alone = leave_markers_out(wrong, X, T, solve=LOOSE)
    mixed = leave_markers_out(wrong, X, T, solve=LOOSE, covariance=covariance)
    assert alone.carry_share == 0
    assert mixed.carry_share > 0
    assert mixed.left_out_mm < alone.left_out_mm


def test_jitter_is_told_from_motion_and_taken_out():
    """Half of what markers that jitter by 0.3 mm a direction are off is not held against the solve."""
    _, T, X = acted()
    noise = np.random.default_rng(3).normal(size=X.shape) * 0.3
    still = np.random.default_rng(4).normal(size=(40, 3)) * 50
    swing = np.sin(np.linspace(0, 6, 50))[:, None, None]
    np.testing.assert_allclose(jitter_of(still + swing + noise), 0.3 * np.sqrt(3), rtol=0.1)
    assert jitter_of(still + swing) < 0.03
    assert jitter_of(still[None]) == 0
    blurred = np.repeat(X[::10], 60, axis=0)
    T = Transform(np.repeat(T.rotation[::10], 60, axis=0), np.repeat(T.translation[::10], 60, axis=0))
    noise = np.random.default_rng(3).normal(size=blurred.shape) * 0.3
    found = leave_markers_out(small_model(), blurred + noise, T, solve=LOOSE)
    np.testing.assert_allclose(found.left_out_mm, np.sqrt(np.mean(found.marker_mm**2) / 2))


def test_a_share_of_one_is_a_frozen_face():
    """Shapes that are told nothing of leave a face at rest, or as far off as one at its mean."""
    _, T, X = acted()
    dumb = replace(small_model(), shapes=np.zeros((6, 40, 3)), neutral=T.inverse().apply(X).mean(axis=0))
    np.testing.assert_allclose(leave_markers_out(dumb, X, T).left_out_share, 1.0, atol=0.15)
