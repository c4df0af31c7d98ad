"""Single frames of a film, by time."""

from collections.abc import Sequence
from pathlib import Path

import av
import numpy as np
from jaxtyping import UInt8

from ..errors import BadInput
from ..files import existing
from .display_matrix import shown_upright


def read_stills(path: str | Path, seconds: Sequence[float]) -> list[UInt8[np.ndarray, "h w 3"]]:
    """The frames on screen at these times from the film's first frame, in the order asked for.

    Raises:
        BadInput: no such file, no film in it, or a time outside the film.
    """
    path = existing(path)
    if min(seconds, default=0) < 0:
        raise BadInput(f"{path}: asked for {min(seconds):.2f} s, before the film begins; --video-offset shifts it")
    try:
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            return _pick(container, list(seconds), path)
    except (av.FFmpegError, IndexError) as error:
        raise BadInput(f"{path}: no film that can be read ({error})") from error


def _pick(container, seconds, path):
    order = np.argsort(seconds, kind="stable")
    stills, waiting, last, end, start = {}, list(order), None, 0.0, None
    length = 1 / 30
    for frame in container.decode(video=0):
        time = float(frame.time or 0.0)
        start = time if start is None else start
        length = time - start - end if last is not None else length
        end = time - start
        while waiting and seconds[waiting[0]] < end - 1e-6:
            stills[waiting.pop(0)] = shown_upright(last or frame)
        last = frame
        if not waiting:
            break
    while waiting and last is not None and seconds[waiting[0]] <= end + length:
        stills[waiting.pop(0)] = shown_upright(last)
    if waiting:
        raise BadInput(
            f"{path}: has no frame at {seconds[waiting[0]]:.2f} s, it lasts {end + length:.2f} s; "
            "is it the take's film? --video-offset shifts it"
        )
    return [stills[i] for i in range(len(seconds))]
