"""Gaps of a take."""

import numpy as np

from mien.takes.gaps import GapConfig, fill_gaps, gap_lengths


def test_gap_lengths_by_hand():
    seen = np.array([[1, 0, 0, 1, 0, 1]], dtype=bool).T
    assert gap_lengths(seen).ravel().tolist() == [0, 2, 2, 0, 1, 0]


def test_short_gaps_follow_the_curve_middling_ones_the_other_markers_and_long_ones_stay():
    rng = np.random.default_rng(0)
    time = np.arange(300) / 60
    sources = np.stack([np.sin(2 * time), np.cos(3 * time), np.sin(time)], 1)
    truth = 10 + np.einsum("ts,smd->tmd", sources, rng.normal(size=(3, 9, 3)) * 4)
    holes = truth.copy()
    holes[50:54, 0], holes[100:120, 1], holes[150:290, 2] = np.nan, np.nan, np.nan
    filled = fill_gaps(holes, 60.0, GapConfig(rank=3, sweeps=60))
    np.testing.assert_allclose(filled[50:54, 0], truth[50:54, 0], atol=0.02)
    np.testing.assert_allclose(filled[100:120, 1], truth[100:120, 1], atol=0.3)
    assert np.isnan(filled[150:290, 2]).all()
    np.testing.assert_array_equal(filled[np.isfinite(holes)], holes[np.isfinite(holes)])


def test_a_frame_in_which_nothing_was_seen_stays_empty():
    X = np.random.default_rng(0).normal(size=(40, 8, 3))
    X[10] = np.nan
    assert np.isnan(fill_gaps(X, 60.0)[10]).all()
