"""A take made ready for scans."""

import numpy as np
import pytest

from marker_stage import motion
from mien.clip import Markers
from mien.errors import BadInput
from mien.takes.preprocess import preprocess_take

STILL = np.random.default_rng(1).normal(size=(12, 3)) * 40
LABELS = tuple(f"M{i}" for i in range(12))


def take(frames: int = 60) -> np.ndarray:
    """A rigid head that moves."""
    return motion(frames, 4).apply(np.tile(STILL, (frames, 1, 1)))


def test_the_heads_motion_is_taken_out_and_gaps_are_filled():
    positions = take()
    positions[10:14, 3] = np.nan
    found = preprocess_take(Markers(positions, LABELS, 60.0))
    assert np.isfinite(found.positions).all()
    still = found.positions - found.positions.mean(axis=0)
    assert np.abs(still).max() < 0.05
    np.testing.assert_array_equal(found.analysed, np.arange(60))
    assert np.isnan(found.markers.positions[10:14, 3]).all()


def test_what_is_hardly_seen_is_left_out_and_told():
    positions = take()
    positions[:40, 5] = np.nan
    positions[50, :7] = np.nan
    positions[55:] = np.nan
    found = preprocess_take(Markers(positions, LABELS, 60.0))
    assert found.left_out == ("M5",)
    assert found.markers.labels == tuple(label for label in LABELS if label != "M5")
    assert 50 not in found.analysed
    assert found.analysed.max() == 54


def test_a_take_that_shows_too_little_is_refused():
    alternate = np.where((np.arange(60)[:, None] % 12 == np.arange(12))[..., None], take(), np.nan)
    with pytest.raises(BadInput, match="no marker is seen in 50%"):
        preprocess_take(Markers(alternate, LABELS, 60.0))
    once = np.where((np.arange(60) == 7)[:, None, None], take(), np.nan)
    with pytest.raises(BadInput, match="2 are needed"):
        preprocess_take(Markers(once, LABELS, 60.0))
