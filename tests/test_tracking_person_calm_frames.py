"""Which frames the neutral is made from, and how neutral they are, on scores told."""

from dataclasses import replace

import numpy as np
import pytest

from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.errors import BadInput
from mien.landmarks.detector import COUNT, Landmarks2D
from mien.progress import SILENT
from mien.rgbd import RgbdTake
from mien.tracking.detect import WrongScale
from mien.tracking.person.calm_frames import calm_frames, judged, resting_frames, telling_scores, with_scale

PICTURE = np.zeros((4, 4, 3), np.uint8)


def take(count: int) -> RgbdTake:
    frames = [RGBDFrame(PICTURE, None, float(i)) for i in range(count)]
    return RgbdTake("told", Camera(4, 4, 2, 2, 4, 4), 1.0, count, False, lambda: iter(frames))


class Smiling:
    """A landmarker that sees these smiles, None for no face, by the clock."""

    def __init__(self, smiles):
        self.smiles = smiles

    def detect(self, image, time=None):
        smile = self.smiles[round(time or 0.0)]
        return None if smile is None else marks(smile)


def marks(smile: float) -> Landmarks2D:
    return Landmarks2D(np.zeros((COUNT, 2)), np.zeros(COUNT), {"mouthSmileLeft": smile, "eyeSquintLeft": 0.9})


def test_a_smile_that_fades_is_left_out():
    frames, found, told = calm_frames(take(12), Smiling([0.8, 0.5, 0.3, None] + [0.02] * 8), 0, 12, SILENT)
    assert [frame.time for frame in frames] == list(range(4, 12))
    assert len(found) == 8
    assert told.left_out == 3
    assert told.neutral
    assert str(told) == "the neutral is frames 4 to 11: at most mouthSmileLeft 0.02 there"


def test_a_smile_that_is_held_is_told_of():
    _, _, told = calm_frames(take(10), Smiling([0.6] * 10), 2, 6, SILENT)
    assert (told.first, told.last) == (2, 7)
    assert not told.neutral
    assert "mouthSmileLeft 0.60" in str(told)
    assert "--neutral" in str(told)


def test_what_the_landmarker_scores_at_rest_says_nothing():
    assert telling_scores([marks(0.1)]).max() == 0.1


def test_some_frames_are_always_kept():
    assert resting_frames(np.array([0.9, 0.1, 0.8, 0.7, 0.6, 0.5, 1.0])) == [1, 2, 3, 4, 5]


def test_judged_by_the_median():
    scores = np.zeros((5, 10))
    scores[0, 2] = 1.0
    scores[1:, 0] = 0.3
    told = judged(scores, [3, 4, 5, 6, 9], 0)
    assert (told.name, told.score, told.last) == ("mouthSmileLeft", 0.3, 9)


def test_no_face_where_the_neutral_is_told_to_be():
    with pytest.raises(BadInput, match="no face from frame 5 on"):
        calm_frames(take(8), Smiling([0.0] * 5 + [None] * 3), 5, 10, SILENT)


def test_the_usual_scale_is_named():
    told = with_scale(WrongScale(1000.0, 4.9), replace(take(1), depth_scale=1000.0))
    assert "--depth-scale 5000" in str(told)
