"""Colour video alone."""

from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np

from ...depth import RGBDFrame
from ...errors import BadInput
from .intrinsics import assumed_camera
from .take import RgbdTake

RATE = 30.0


def read_video(path: Path, focal: float | None = None) -> RgbdTake:
    """Open a video; its lens is assumed to see 60 degrees across the longer side unless `focal` (pixels) is given.

    Raises:
        BadInput: no video in it.
    """
    try:
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            width, height = stream.codec_context.width, stream.codec_context.height
            rate = float(stream.average_rate or RATE)
            count = stream.frames or round(float((container.duration or 0) / 1e6) * rate)
    except (av.FFmpegError, IndexError, OSError) as error:
        raise BadInput(f"{path}: no video that can be read ({error})") from error
    camera = assumed_camera(width, height, focal)

    def frames() -> Iterator[RGBDFrame]:
        yield from _frames(path, rate)

    return RgbdTake(path.name, camera, rate, max(count, 1), False, frames, guessed_camera=focal is None)


def _frames(path: Path, rate: float) -> Iterator[RGBDFrame]:
    done, start = 0, None
    try:
        with av.open(str(path)) as container:
            for frame in container.decode(video=0):
                seen = frame.time if frame.time is not None else done / rate
                start = seen if start is None else start
                yield RGBDFrame(np.ascontiguousarray(frame.to_ndarray(format="rgb24")), None, float(seen - start))
                done += 1
    except (av.FFmpegError, OSError) as error:
        raise BadInput(f"{path}: breaks off after frame {done - 1} ({error})") from error
