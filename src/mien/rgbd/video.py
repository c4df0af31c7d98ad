"""Colour video alone."""

from collections.abc import Iterator
from pathlib import Path

import av

from ..depth import RGBDFrame
from ..errors import BadInput
from .display_matrix import shown_upright
from .intrinsics import assumed_camera
from .take import RgbdTake

RATE = 30.0


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
            first = next(container.decode(video=0), None)
    except (av.FFmpegError, IndexError, OSError) as error:
        raise BadInput(f"{path}: no video that can be read ({error})") from error
    if first is None:
        raise BadInput(f"{path}: no video that can be read (it holds no frame)")
    height, width = shown_upright(first).shape[:2]
    notes = () if height == first.height else (f"{path.name}: filmed sideways; turned upright, as it says",)
    camera = assumed_camera(width, height, focal)

    def frames() -> Iterator[RGBDFrame]:
        yield from _frames(path, rate)

    return RgbdTake(path.name, camera, rate, max(count, 1), False, frames, guessed_camera=focal is None, notes=notes)


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
