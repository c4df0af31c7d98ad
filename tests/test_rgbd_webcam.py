"""This computer's camera."""

import threading
import time

import numpy as np
import pytest

from mien.errors import BadInput
from mien.rgbd.live import live_frames
from mien.rgbd.webcam import Webcam, open_webcam
from rgbd_takes import CAMERA


def test_a_webcam_gives_the_newest_picture_once_and_ends_with_the_last():
    pictures, go = [np.full((2, 2, 3), i, np.uint8) for i in range(5)], threading.Event()

    def stream():
        yield from pictures[:3]
        go.wait(5)
        yield from pictures[3:]

    camera = Webcam(stream(), CAMERA, 30.0, seconds=60.0)
    time.sleep(0.1)
    first = camera.latest()
    go.set()
    seen = [frame.color[0, 0, 0] for frame in live_frames(camera)]
    assert first.color[0, 0, 0] == 2
    assert first.depth is None
    assert seen[-1] == 4
    assert len(seen) <= 2
    assert camera.latest() is None


def test_a_webcam_stops_after_its_time():
    def endless():
        while True:
            time.sleep(0.01)
            yield np.zeros((2, 2, 3), np.uint8)

    times = [frame.time for frame in live_frames(Webcam(endless(), CAMERA, 100.0, seconds=0.1))]
    assert len(times) >= 2
    assert times[-1] < 0.1
    assert (np.diff(times) > 0).all()


def test_no_camera_is_said_in_one_line():
    with pytest.raises(BadInput, match=r"/dev/nothing: no camera to be opened .*--device"):
        open_webcam(1.0, "/dev/nothing")
    with pytest.raises(BadInput, match="seconds: expected above 0, got 0"):
        open_webcam(0.0)
