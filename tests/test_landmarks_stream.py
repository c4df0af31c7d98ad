"""Landmarks worked out in a thread beside the frames."""

import numpy as np
import pytest

import tracking_stage as stage
from mien.depth import RGBDFrame
from mien.errors import BadInput
from mien.landmarks.detector import Landmarks2D
from mien.landmarks.stream import with_landmarks


@pytest.mark.parametrize("late", [False, True])
def test_landmarks_come_in_step_or_one_frame_late(late):
    frames = [RGBDFrame(np.zeros((2, 2, 3), np.uint8), None, float(t)) for t in range(5)]
    answers = {float(t): Landmarks2D(np.full((478, 2), float(t)), np.zeros(478), {}) for t in range(5)}
    pairs = with_landmarks(frames, stage.Told(answers), late=late)
    seen = [(f.time, None if m is None else m.points[0, 0]) for f, m in pairs]
    expected = [(0.0, None), (1.0, 0.0), (2.0, 1.0), (3.0, 2.0), (4.0, 3.0)] if late else [(t, t) for t in range(5)]
    assert seen == expected


@pytest.mark.parametrize("late", [False, True])
def test_a_walk_that_breaks_off_gives_the_frames_before_the_break(late):
    def broken():
        yield RGBDFrame(None, np.ones((2, 2), np.float32), 0.0)
        yield RGBDFrame(np.zeros((2, 2, 3), np.uint8), None, 1.0)
        raise BadInput("cut off")

    walk = with_landmarks(broken(), stage.Told({1.0: None}), late=late)
    assert [next(walk)[0].time for _ in range(2)] == [0.0, 1.0]
    with pytest.raises(BadInput, match="cut off"):
        next(walk)
