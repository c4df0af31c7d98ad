"""Record3D's `.r3d`: a zip of JPEG colour and LZFSE-compressed float32 depth in metres, from an iPhone or iPad."""

import json
import re
import zipfile
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from ..camera import Camera
from ..depth import RGBDFrame
from ..errors import BadInput
from ..extras import require
from .folder import resized
from .intrinsics import matrix_values
from .take import RgbdTake

LONGEST = 640
"""Colour and depth are brought to one size, at most so many pixels a side: more than the depth sensors resolve."""
_ASPECT_SLACK = 0.06
"""How far depth's aspect may be off colour's, as a logarithm of the ratio."""

_DAMAGED = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, SyntaxError)
"""What the packages that unpack zip archives and pictures raise on damaged ones."""


def read_record3d(path: Path) -> RgbdTake:
    """Open a Record3D recording.

    Raises:
        BadInput: not such a file, or the extra `record3d` is missing.
    """
    require("lzfse", "record3d")
    try:
        with zipfile.ZipFile(path) as archive:
            about = json.loads(archive.read("metadata"))
            names = set(archive.namelist())
    except (*_DAMAGED, KeyError, ValueError, OSError) as error:
        raise BadInput(f"{path}: not a whole Record3D recording ({error}); export it again") from error
    numbers, notes, has_depth = _frames_of(path, names)
    if not numbers:
        raise BadInput(f"{path}: not a whole Record3D recording (no rgbd/0.jpg); export it again")
    camera, depth_size = _camera(path, about, numbers)
    rate, times = _clock(path, about, numbers)

    def frames() -> Iterator[RGBDFrame]:
        with zipfile.ZipFile(path) as archive:
            for i, time in zip(numbers, times - times[:1], strict=True):
                yield _frame(path, archive, i, camera, depth_size, float(time))

    return RgbdTake(path.name, camera, rate, len(numbers), has_depth, frames, notes=notes)


def _clock(path: Path, about: dict, numbers: list[int]) -> tuple[float, np.ndarray]:
    """(rate, seconds of every frame)."""
    try:
        rate = float(about.get("fps", 30))
        if not 0 < rate < np.inf:
            raise ValueError(f"fps {rate:g}")
        stamps, count = about.get("frameTimestamps") or [], max(numbers) + 1
        times = np.array(stamps if len(stamps) >= count else np.arange(count) / rate, float)[numbers]
        if times.shape != (len(numbers),) or not np.isfinite(times).all():
            raise ValueError("frameTimestamps are not one number a frame")
    except (ValueError, TypeError, AttributeError, OverflowError) as error:
        raise BadInput(f"{path}: its metadata tells no clock ({error}); export it again") from error
    return rate, times


def _frames_of(path: Path, names: set[str]) -> tuple[list[int], tuple[str, ...], bool]:
    """Numbers of the frames that are whole, lines on what is missing, and whether there is depth at all."""
    color, depth = (
        {int(match[1]) for name in names if (match := re.fullmatch(rf"rgbd/(\d+)\.{suffix}", name))}
        for suffix in ("jpg", "depth")
    )
    if not depth:
        return sorted(color), (f"{path.name}: holds no depth; tracked from colour alone",), False
    whole = sorted(color & depth)
    alone = len(color ^ depth)
    notes = (f"{path.name}: {alone} colour or depth images have no partner and are left out",) if alone else ()
    return whole, notes, True


def _camera(path: Path, about: dict, numbers: list[int]) -> tuple[Camera, tuple[int, int] | None]:
    """The camera at the size that both images are brought to; width and height of the depth where the file says."""
    try:
        if "w" in about and "h" in about:
            width, height = int(about["w"]), int(about["h"])
        else:
            with zipfile.ZipFile(path) as archive, Image.open(BytesIO(archive.read(f"rgbd/{numbers[0]}.jpg"))) as image:
                width, height = image.size
        known = "dw" in about and "dh" in about
        depth_size = (int(about["dw"]), int(about["dh"])) if known else None
        full = Camera(*matrix_values(about["K"]), width, height)
    except (*_DAMAGED, KeyError, ValueError, TypeError, IndexError, AttributeError, OverflowError, OSError) as error:
        raise BadInput(f"{path}: its metadata lacks w, h or K ({error!r}); export it again") from error
    return full.scaled(min(1.0, LONGEST / max(width, height))), depth_size


def depth_shape(count: int, width: int, height: int) -> tuple[int, int]:
    """Width and height of a depth image of `count` pixels that shows what a colour image of that size does.

    Raises:
        ValueError: no whole numbers come near that aspect.
    """
    widths = np.array([w for w in range(1, count + 1) if count % w == 0]) if count else np.zeros(0, int)
    off = np.abs(np.log(widths * widths / max(count, 1)) - np.log(width / height))
    if not len(widths) or off.min() > _ASPECT_SLACK:
        raise ValueError(f"{count} depths do not make an image of the aspect {width} x {height}")
    best = int(widths[off.argmin()])
    return best, count // best


def _frame(path: Path, archive: zipfile.ZipFile, i: int, camera: Camera, depth_size, time: float) -> RGBDFrame:
    size = (camera.width, camera.height)
    try:
        with Image.open(BytesIO(archive.read(f"rgbd/{i}.jpg"))) as image:
            color = np.asarray(image.convert("RGB").resize(size, Image.Resampling.BOX))
        if f"rgbd/{i}.depth" not in archive.namelist():
            return RGBDFrame(color, None, time)
        metres = np.frombuffer(_unpacked(archive.read(f"rgbd/{i}.depth")), np.float32)
        wide, high = depth_size or depth_shape(len(metres), *size)
        depth = metres.reshape(high, wide) * np.float32(1000)
    except (*_DAMAGED, KeyError, OSError, ValueError) as error:
        raise BadInput(f"{path}: frame {i} cannot be read ({error}); the take was cut off there") from error
    return RGBDFrame(color, np.ascontiguousarray(resized(depth, (size[1], size[0]))), time)


def _unpacked(packed: bytes) -> bytes:
    """lzfse tells damage by an exception of its own or by MemoryError.

    Raises:
        ValueError: damaged.
    """
    lzfse = require("lzfse", "record3d")
    try:
        return lzfse.decompress(packed)
    except (lzfse.error, MemoryError, RuntimeError) as error:
        raise ValueError(f"its depth is damaged ({error!r})") from error
