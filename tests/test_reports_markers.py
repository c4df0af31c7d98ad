import numpy as np

from mien.clip import Markers
from mien.reports.markers import telling_frames, worst_markers
from studio_things import nodding


def test_the_worst_markers_come_first_and_unseen_ones_not_at_all():
    positions = np.zeros((4, 7, 3))
    positions[:2, 5] = np.nan
    residuals = np.tile(np.arange(7.0), (4, 1))
    residuals[:, 6] = np.nan
    worst = worst_markers(residuals, Markers(positions, tuple("abcdefg"), 30.0))
    assert [row[0] for row in worst] == ["f", "e", "d", "c", "b"]
    assert worst[0] == ("f", 5.0, "50%")


def test_telling_frames_differ_and_stand_in_order():
    frames = telling_frames(nodding(31), 4)
    assert frames == sorted(set(frames))
    assert len(frames) == 4
