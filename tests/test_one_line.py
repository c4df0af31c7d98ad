"""Nouns print as one line that a person can read."""

import numpy as np
import pytest

import mien
from mien.one_line import count, one_line

FACE = mien.load_face()
TAKE = mien.Markers(np.where(np.arange(60).reshape(10, 2, 3) < 3, np.nan, 1.0), ("a", "b"), 60.0)


@pytest.mark.parametrize(
    ("noun", "line"),
    [
        (FACE.rig.neutral, "Mesh(4,818 vertices, 9,448 faces, uv, vertex colours)"),
        (FACE, "BundledFace(Rig(52 shapes, 4,818 vertices))"),
        (TAKE, "Markers(2 markers, 10 frames at 60 a second (0.2 s), 5.0% unseen)"),
        (mien.Attachment(np.zeros(1, int), np.ones((1, 3)) / 3), "Attachment(1 point)"),
        (mien.Scan(mien.Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])), name="a"), "Scan(a, Mesh(3 vertices, 1 face))"),
        (mien.RGBDFrame(np.zeros((2, 4, 3), np.uint8), None, 0.5), "RGBDFrame(0.500 s, colour of 4 x 2 pixels)"),
        (mien.Transform.identity(), "Transform(turn 0.0 degrees, move (0.0, 0.0, 0.0) mm)"),
        (mien.Transform.identity(5), "Transform(batch of 5)"),
        (
            mien.Performance(FACE.rig, np.zeros((2, 52)), mien.Transform.identity(2), 30.0, np.array([True, False])),
            "Performance(2 frames at 30 a second (0.1 s), 1 tracked, Rig(52 shapes, 4,818 vertices))",
        ),
    ],
)
def test_nouns(noun, line):
    assert repr(noun) == line


def test_facts_that_are_missing_are_left_out():
    assert one_line(TAKE, "a", None, "", 0) == "Markers(a, 0)"
    assert [count(1, word) for word in ("frames", "vertices", "bodies")] == ["1 frame", "1 vertex", "1 body"]
    assert count(1200, "frames") == "1,200 frames"
