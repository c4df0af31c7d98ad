"""Rank correlation, by hand."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.stage.rank_correlation import rank_correlation


def test_any_rising_figure_has_rank_one():
    true = np.array([0.2, 0.5, 0.9, 3.0])
    assert rank_correlation(np.exp(true), true) == pytest.approx(1.0)
    assert rank_correlation(-true, true) == pytest.approx(-1.0)


def test_ties_and_gaps_by_hand():
    assert rank_correlation(np.array([1.0, 1.0, 2.0]), np.array([1.0, 2.0, 3.0])) == pytest.approx(np.sqrt(3) / 2)
    gappy = np.array([1.0, np.nan, 2.0, 3.0])
    assert rank_correlation(gappy, np.array([1.0, 0.0, 2.0, 3.0])) == pytest.approx(1.0)
    assert rank_correlation(np.ones(4), np.arange(4.0)) == 0.0


def test_two_takes_say_nothing():
    with pytest.raises(BadInput, match="at least 3"):
        rank_correlation(np.ones(2), np.ones(2))
