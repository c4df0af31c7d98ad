"""Frames that come by themselves: what a live source must do, and a recorded take that plays the part."""

import time
from collections.abc import Callable, Iterator
from typing import Protocol, runtime_checkable

from ..camera import Camera
from ..depth import RGBDFrame
from .take import RgbdTake


@runtime_checkable
class LiveSource(Protocol):
    """A camera that does not wait: whoever is late misses frames."""

    camera: Camera
    rate: float

    def latest(self) -> RGBDFrame | None:
        """The newest frame that has not been given yet; waits for it if there is none. None when all is over."""
        ...


class Replay:
    """A take that keeps the clock: each frame is there at its time, and gone when the next one comes."""

    def __init__(
        self,
        take: RgbdTake,
        speed: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ):
        """`speed` 2 plays twice as fast. `clock` and `sleep` in seconds; tests give their own."""
        if not speed > 0:
            raise ValueError(f"speed: expected above 0, got {speed}")
        self.camera, self.rate = take.camera, take.rate * speed
        self.missed = 0
        """Frames that came and went unseen."""
        self._frames: Iterator[RGBDFrame] = iter(take)
        self._speed, self._clock, self._sleep = speed, clock, sleep
        self._start: float | None = None
        self._next: RGBDFrame | None = next(self._frames, None)

    def latest(self) -> RGBDFrame | None:
        """The newest frame whose time has come; waits for the first one, None after the last."""
        if self._next is None:
            return None
        now = self._clock()
        if self._start is None:
            self._start = now - self._next.time / self._speed
        wait = self._start + self._next.time / self._speed - now
        if wait > 0:
            self._sleep(wait)
        elapsed = (self._clock() - self._start) * self._speed
        frame, self._next = self._next, next(self._frames, None)
        while self._next is not None and self._next.time <= elapsed:
            self.missed += 1
            frame, self._next = self._next, next(self._frames, None)
        return frame


def live_frames(source: LiveSource) -> Iterator[RGBDFrame]:
    """The frames of a live source as they come, until it ends."""
    while (frame := source.latest()) is not None:
        yield frame
