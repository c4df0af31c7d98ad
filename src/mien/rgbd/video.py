"""Colour video alone."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import numpy as np
from jaxtyping import Float

from ..depth import RGBDFrame
from ..errors import BadInput
from .display_matrix import shown_upright
from .intrinsics import assumed_camera
from .take import RgbdTake

RATE = 30.0
"""Of a film that tells none."""
_RATE_SLACK = 0.01
"""How far the rate that a file states may be off the times of its frames, as a share."""
_UNEVEN_FRAMES = 1.0
"""From how many frames' length on, off an even clock, uneven frames are told of."""


def read_video(path: Path, focal: float | None = None) -> RgbdTake:
    """Open a video, upright as it asks to be shown, frames at their own times.

    Its lens is assumed to see 60 degrees across the longer side unless `focal` (pixels) is given.

    Raises:
        BadInput: no video in it.
    """
    try:
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            rate = float(stream.average_rate or RATE)
            count = stream.frames or round(float((container.duration or 0) / 1e6) * rate)
            times = _times(container, stream)
        with av.open(str(path)) as container:
            first = next(container.decode(video=0), None)
    except (av.FFmpegError, IndexError, OSError) as error:
        raise BadInput(f"{path}: no video that can be read ({error})") from error
    if first is None:
        raise BadInput(f"{path}: no video that can be read (it holds no frame)")
    height, width = shown_upright(first).shape[:2]
    rate, notes = _even_rate(path, rate, times)
    if height != first.height:
        notes = (f"{path.name}: filmed sideways; turned upright, as it says", *notes)
    camera = assumed_camera(width, height, focal)

    def frames() -> Iterator[RGBDFrame]:
        yield from _frames(path, rate)

    return RgbdTake(path.name, camera, rate, max(count, 1), False, frames, guessed_camera=focal is None, notes=notes)


def _times(container: Any, stream: Any) -> Float[np.ndarray, " frames"]:
    """When the frames are shown, seconds, in order, without decoding them; none where the file does not say of all."""
    times: list[float | None] = []
    try:
        for packet in container.demux(stream):
            if packet.size:
                times.append(None if packet.pts is None else float(packet.pts * packet.time_base))
    except (av.FFmpegError, OSError):
        pass  # a film that breaks off is told of where its frames are read
    return np.sort([] if None in times else np.array(times, float))


def _even_rate(path: Path, stated: float, times: Float[np.ndarray, " frames"]) -> tuple[float, tuple[str, ...]]:
    """Frames a second that fill the time the frames do, and a line where they come unevenly."""
    took = float(np.ptp(times)) if len(times) > 1 else 0.0
    if not took > 0:
        return stated, ()
    measured = (len(times) - 1) / took
    rate = stated if abs(measured / stated - 1) <= _RATE_SLACK else measured
    off = np.abs(times - times[0] - np.arange(len(times)) / rate).max()
    if off * rate <= _UNEVEN_FRAMES:
        return rate, ()
    return rate, (
        f"{path.name}: its frames come unevenly; at an even {rate:.4g}/s some are off by {off * 1000:.0f} ms",
    )


def _frames(path: Path, rate: float) -> Iterator[RGBDFrame]:
    done, start = 0, None
    try:
        with av.open(str(path)) as container:
            for frame in container.decode(video=0):
                seen = frame.time if frame.time is not None else done / rate
                start = seen if start is None else start
                yield RGBDFrame(shown_upright(frame), None, float(seen - start))
                done += 1
    except (av.FFmpegError, OSError) as error:
        raise BadInput(f"{path}: breaks off after frame {done - 1} ({error})") from error
