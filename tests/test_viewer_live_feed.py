import json
import threading

import numpy as np
import pytest

from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.rgbd import RgbdTake
from mien.transforms import Transform
from mien.viewer.live_feed import LiveFeed, small_jpeg

CAMERA = Camera(100.0, 100.0, 4.0, 3.0, 9, 7)
PLACE = Transform(np.eye(3), np.array([1.0, 2.0, -500.0]))


def unpacked(message):
    whole, text, numbers = np.frombuffer(message[:12], "<u4")
    assert len(message) == 12 + whole
    values = np.frombuffer(message[12 + text : 12 + text + numbers], "<f4")
    return json.loads(message[12 : 12 + text]), values, message[12 + text + numbers :]


def first_message(feed):
    """What a page that comes now hears first."""
    heard = []

    def write(message):
        heard.append(message)
        raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        feed._send(write, {})
    return unpacked(heard[0])


def take(count=3):
    picture = np.full((7, 9, 3), 90, np.uint8)
    frames = [RGBDFrame(picture, None, i / 30) for i in range(count)]
    return RgbdTake("take", CAMERA, 30.0, count, False, lambda: iter(frames))


def test_a_page_hears_weights_head_stages_and_picture():
    feed = LiveFeed(lambda frames: "")
    next(iter(feed.watched(take())))
    with feed.stage("fit"):
        pass
    feed.show(np.array([0.25, 0.5]), PLACE, True)
    told, values, picture = first_message(feed)
    np.testing.assert_allclose(values, [0.25, 0.5, 0, 0, 0, 0, 0, 0, 1])
    assert told["tracked"]
    assert list(told["ms"]) == ["fit"]
    assert picture[:2] == bytes([0xFF, 0xD8])
    assert values.nbytes <= 1000


def test_the_neutral_that_is_held_becomes_nothing():
    feed = LiveFeed(lambda frames: "")
    feed.show(np.array([0.2, 0.0]), PLACE, True)
    assert feed._calibrate(b"on", {}).body == b"calibrated"
    np.testing.assert_allclose(feed.calibrated(np.array([0.2, 0.0])), 0)
    np.testing.assert_allclose(feed.calibrated(np.array([1.0, 0.5])), [1.0, 0.5])
    feed._calibrate(b"off", {})
    np.testing.assert_allclose(feed.calibrated(np.array([0.2, 0.0])), [0.2, 0.0])


def test_what_passes_between_two_presses_is_kept():
    kept = []
    feed = LiveFeed(lambda frames: kept.append(len(frames)) or "recorded")
    passing = iter(feed.watched(take(4)))
    next(passing)
    assert feed._record(b"", {}).body == b"recording"
    next(passing), next(passing)
    assert feed._record(b"", {}).body == b"recorded"
    next(passing)
    assert kept == [2]


def test_a_page_waits_for_news():
    feed = LiveFeed(lambda frames: "")
    feed.show(np.zeros(2), PLACE, True)
    heard, second = [], threading.Event()

    def write(message):
        heard.append(unpacked(message)[1][0])
        if len(heard) == 2:
            second.set()
            raise BrokenPipeError

    def look_on():
        with pytest.raises(BrokenPipeError):
            feed._send(write, {})

    page = threading.Thread(target=look_on)
    page.start()
    while not heard:
        pass
    feed.show(np.ones(2), PLACE, True)
    assert second.wait(10)
    page.join()
    assert heard == [0.0, 1.0]


def test_pictures_are_made_small():
    assert len(small_jpeg(np.zeros((1080, 1920, 3), np.uint8))) < 20_000
