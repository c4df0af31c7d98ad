"""A take played by the clock."""

import numpy as np
import pytest

from mien.rgbd.live import Replay, live_frames
from rgbd_takes import made


class Clock:
    """Time that passes only in sleep, or when somebody works."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def test_replay_keeps_the_clock_and_drops_what_nobody_waited_for():
    clock = Clock()
    source = Replay(made(10, rate=10.0), clock=clock, sleep=clock.sleep)
    seen = []
    for frame in live_frames(source):
        seen.append((round(frame.time, 3), round(clock.now - 100, 3)))
        clock.now += 0.25 if len(seen) == 2 else 0.01
    assert [t for t, _ in seen] == [0.0, 0.1, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]
    assert source.missed == 1
    assert all(now >= t - 1e-9 for t, now in seen)


def test_replay_at_double_speed():
    clock = Clock()
    times = [clock.now for _ in live_frames(Replay(made(5, rate=10.0), speed=2.0, clock=clock, sleep=clock.sleep))]
    np.testing.assert_allclose(times[-1] - 100, 0.2)
    with pytest.raises(ValueError, match="speed: expected above 0"):
        Replay(made(), speed=0.0)
