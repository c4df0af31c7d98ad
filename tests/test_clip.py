"""The noun of a marker take."""

import numpy as np
import pytest

from mien.clip import Markers, visible


def test_visible_needs_all_three():
    positions = np.zeros((2, 2, 3))
    positions[0, 1, 2] = np.nan
    positions[1, 0, 0] = np.inf
    np.testing.assert_array_equal(visible(positions), [[True, False], [False, True]])


def test_labels_and_positions_must_agree():
    with pytest.raises(ValueError, match="expected 2, one a marker, got 1"):
        Markers(np.zeros((1, 2, 3)), ("a",), 60.0)


def test_with_positions_keeps_the_rest():
    markers = Markers(np.zeros((1, 1, 3)), ("a",), 60.0, {"mood": np.array(["calm"])})
    moved = markers.with_positions(np.ones((1, 1, 3)))
    assert (moved.labels, moved.rate, moved.notes) == (markers.labels, 60.0, markers.notes)
    assert moved.seen.all()
