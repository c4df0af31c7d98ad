"""A take is walked through anew each time."""

from mien.camera import Camera
from mien.rgbd.take import RgbdTake


def test_it_is_walked_through_twice_and_prints_as_one_line():
    walks = []

    def frames():
        walks.append(1)
        yield from "abc"

    take = RgbdTake("talk", Camera(9.0, 9.0, 3.5, 2.5, 8, 6), 30.0, 3, True, frames)
    assert list(take) == list(take) == ["a", "b", "c"]
    assert (len(walks), len(take)) == (2, 3)
    assert "talk" in repr(take)
    assert "3 frames at 30 a second, colour and depth" in repr(take)
