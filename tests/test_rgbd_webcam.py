"""This computer's camera."""

import threading
from itertools import count

import numpy as np
import pytest

from mien.errors import BadInput
from mien.rgbd.live import live_frames
from mien.rgbd.webcam import Webcam, open_webcam
from rgbd_takes import CAMERA


def test_a_webcam_gives_the_newest_picture_once_and_ends_with_the_last():
    pictures = [np.full((2, 2, 3), i, np.uint8) for i in range(5)]
    asked, go = threading.Event(), threading.Event()

    def stream():
        yield from pictures[:3]
        asked.set()
        go.wait()
        yield from pictures[3:]

    camera = Webcam(stream(), CAMERA, 30.0, seconds=1e6)
    asked.wait()
    first = camera.latest()
    go.set()
    seen = [frame.color[0, 0, 0] for frame in live_frames(camera)]
    assert first.color[0, 0, 0] == 2
    assert first.depth is None
    assert seen[-1] == 4
    assert len(seen) <= 2
    assert camera.latest() is None


def test_a_webcam_stops_after_its_time():
    clock = count(step=0.25).__next__
    given = []

    def endless():
        while True:
            given.append(1)
            yield np.zeros((2, 2, 3), np.uint8)

    camera = Webcam(endless(), CAMERA, 100.0, seconds=1.0, clock=clock)
    times = [frame.time for frame in live_frames(camera)]
    assert len(given) == 5
    assert times[-1] == 0.75
    assert (np.diff(times) > 0).all()


def test_no_camera_is_said_in_one_line():
    with pytest.raises(BadInput, match=r"/dev/nothing: no camera to be opened .*--device"):
        open_webcam(1.0, "/dev/nothing")
    with pytest.raises(BadInput, match="seconds: expected above 0, got 0"):
        open_webcam(0.0)
