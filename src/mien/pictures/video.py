"""Pictures and films on disk."""

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from jaxtyping import UInt8
from PIL import Image

from ..errors import BadInput
from ..files import whole


def write_png(path: str | Path, image: UInt8[np.ndarray, "h w c"]) -> None:
    """Write an RGB or RGBA picture; whole or not at all.

    Raises:
        BadInput: the folder does not exist.
    """
    with whole(path) as temporary:
        Image.fromarray(image).save(temporary, format="PNG", optimize=False, compress_level=6)


def write_mp4(
    path: str | Path, frames: Iterable[UInt8[np.ndarray, "h w 3"]], rate: float, quality: int = 18
) -> int:
    """Write a film (H.264, yuv420p: plays everywhere), frame by frame as they come; whole or not at all.

    Args:
        frames: RGB, all of one size; an odd last row or column is left out, as the format asks for even sizes.
        rate: frames a second.
        quality: x264's constant rate factor, 0 = lossless, 51 = worst.

    Returns:
        How many frames were written.

    Raises:
        BadInput: no frame, frames that differ in size, a rate that is not positive, or no such folder.
    """
    if not rate > 0:
        raise BadInput(f"{path}: the frame rate must be positive, got {rate:g}")
    count, size = 0, None
    begin_with_index = {"movflags": "faststart"}
    with whole(path) as temporary, av.open(str(temporary), "w", format="mp4", options=begin_with_index) as film:
        stream = None
        for frame in frames:
            if stream is None:
                size = frame.shape
                stream = _stream(film, size, rate, quality)
            if frame.shape != size:
                raise BadInput(f"{path}: frame {count} has shape {frame.shape}, the ones before it {size}")
            even = np.ascontiguousarray(frame[: stream.height, : stream.width])
            film.mux(stream.encode(av.VideoFrame.from_ndarray(even, format="rgb24")))
            count += 1
        if stream is None:
            raise BadInput(f"{path}: a film needs at least one frame")
        film.mux(stream.encode())
    return count


def _stream(film, shape: tuple[int, ...], rate: float, quality: int):
    stream = film.add_stream("libx264", rate=Fraction(rate).limit_denominator(60000))
    stream.height, stream.width = shape[0] // 2 * 2, shape[1] // 2 * 2
    if stream.height == 0 or stream.width == 0:
        raise BadInput(f"a film needs frames of at least 2 x 2 pixels, got {shape[1]} x {shape[0]}")
    stream.pix_fmt = "yuv420p"
    stream.options = {"crf": str(quality), "preset": "veryfast"}
    return stream
