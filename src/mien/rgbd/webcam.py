"""A webcam as a take: colour alone, read by PyAV in a thread of its own, so that what is given is always the newest."""

import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing

import av
import numpy as np

from ..camera import Camera
from ..depth import RGBDFrame
from ..errors import BadInput
from .intrinsics import assumed_camera
from .live import live_frames
from .take import RgbdTake

DRIVERS = {"linux": ("v4l2", "/dev/video0"), "darwin": ("avfoundation", "0"), "win32": ("dshow", "video=0")}
"""FFmpeg's camera driver and first device by platform."""


class Webcam:
    """`mien.rgbd.live.LiveSource` of pictures that come by themselves; ends after `seconds`, or when they end."""

    def __init__(
        self,
        pictures: Iterable[np.ndarray],
        camera: Camera,
        rate: float,
        seconds: float,
        clock: Callable[[], float] = time.monotonic,
    ):
        """`clock` in seconds; tests give their own."""
        self.camera, self.rate, self._clock = camera, rate, clock
        self._seconds, self._given, self._number = seconds, 0, 0
        self._newest: RGBDFrame | None = None
        self._over = False
        self._turn = threading.Condition()
        threading.Thread(target=self._read, args=(pictures,), daemon=True, name="camera").start()

    def latest(self) -> RGBDFrame | None:
        """The newest picture that has not been given yet; waits for it. None when all is over."""
        with self._turn:
            self._turn.wait_for(lambda: self._over or self._number > self._given)
            if self._number == self._given:
                return None
            self._given = self._number
            return self._newest

    def _read(self, pictures: Iterable[np.ndarray]) -> None:
        start = None
        try:
            for picture in pictures:
                now = self._clock()
                start = now if start is None else start
                if now - start >= self._seconds:
                    break
                with self._turn:
                    self._newest, self._number = RGBDFrame(picture, None, now - start), self._number + 1
                    self._turn.notify()
        finally:
            with self._turn:
                self._over = True
                self._turn.notify()


def open_webcam(seconds: float, device: str | None = None, focal: float | None = None) -> RgbdTake:
    """The first camera of this computer, or `device`, for so many seconds: a take that can be walked through once.

    Raises:
        BadInput: no camera that can be opened, or a time that is not positive.
    """
    if not seconds > 0:
        raise BadInput(f"seconds: expected above 0, got {seconds:g}")
    driver, first = DRIVERS.get(sys.platform, DRIVERS["linux"])
    name = device or first
    try:
        container = av.open(name, format=driver)
        stream = container.streams.video[0]
    except (av.FFmpegError, IndexError, OSError, ValueError) as error:
        raise BadInput(f"{name}: no camera to be opened ({error}); plug one in, or name it by --device") from error
    width, height = stream.codec_context.width, stream.codec_context.height
    rate, camera = float(stream.average_rate or 30.0), assumed_camera(width, height, focal)

    def frames() -> Iterator[RGBDFrame]:
        with closing(container):
            pictures = (np.ascontiguousarray(f.to_ndarray(format="rgb24")) for f in container.decode(video=0))
            yield from live_frames(Webcam(pictures, camera, rate, seconds))

    return RgbdTake(name, camera, rate, max(round(rate * seconds), 1), False, frames, guessed_camera=focal is None)
