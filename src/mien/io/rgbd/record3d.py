"""Record3D's `.r3d`: a zip of JPEG colour and LZFSE-compressed float32 depth in metres, from an iPhone or iPad."""

import json
import zipfile
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from ...camera import Camera
from ...depth import RGBDFrame
from ...errors import BadInput
from .take import RgbdTake

LONGEST = 640
"""Colour and depth are brought to one size, at most so many pixels a side: more than the depth sensors resolve."""

_DAMAGED = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, SyntaxError)
"""What the packages that unpack zip archives and pictures raise on damaged ones."""


def read_record3d(path: Path) -> RgbdTake:
    """Open a Record3D recording.

    Raises:
        BadInput: not such a file, or the extra `record3d` is missing.
    """
    _lzfse()
    try:
        with zipfile.ZipFile(path) as archive:
            about = json.loads(archive.read("metadata"))
            names = set(archive.namelist())
    except (*_DAMAGED, KeyError, ValueError, OSError) as error:
        raise BadInput(f"{path}: not a whole Record3D recording ({error}); export it again") from error
    count = sum(1 for i in range(len(names)) if f"rgbd/{i}.depth" in names)
    camera, depth_size = _camera(path, about)
    rate, times = _clock(path, about, count)

    def frames() -> Iterator[RGBDFrame]:
        with zipfile.ZipFile(path) as archive:
            for i, time in enumerate(times - times[:1]):
                yield _frame(path, archive, i, camera, depth_size, float(time))

    return RgbdTake(path.name, camera, rate, count, True, frames)


def _clock(path: Path, about: dict, count: int) -> tuple[float, np.ndarray]:
    """(rate, seconds of every frame)."""
    try:
        rate = float(about.get("fps", 30))
        if not 0 < rate < np.inf:
            raise ValueError(f"fps {rate:g}")
        times = np.array(about.get("frameTimestamps") or np.arange(count) / rate, float)[:count]
        if times.shape != (count,) or not np.isfinite(times).all():
            raise ValueError("frameTimestamps are not one number a frame")
    except (ValueError, TypeError, AttributeError, OverflowError) as error:
        raise BadInput(f"{path}: its metadata tells no clock ({error}); export it again") from error
    return rate, times


def _camera(path: Path, about: dict) -> tuple[Camera, tuple[int, int]]:
    """The camera at the size that both images are brought to; width and height of the depth."""
    try:
        width, height, m = int(about["w"]), int(about["h"]), [float(value) for value in about["K"]]
        depth_size = (int(about.get("dw", width)), int(about.get("dh", height)))
        full = Camera(m[0], m[4], m[6], m[7], width, height)
    except (KeyError, ValueError, TypeError, IndexError, AttributeError, OverflowError) as error:
        raise BadInput(f"{path}: its metadata lacks w, h or K ({error!r}); export it again") from error
    return full.scaled(min(1.0, LONGEST / max(width, height))), depth_size


def _frame(path: Path, archive: zipfile.ZipFile, i: int, camera: Camera, depth_size, time: float) -> RGBDFrame:
    size = (camera.width, camera.height)
    try:
        with Image.open(BytesIO(archive.read(f"rgbd/{i}.jpg"))) as image:
            color = np.asarray(image.convert("RGB").resize(size, Image.Resampling.BOX))
        metres = np.frombuffer(_unpacked(archive.read(f"rgbd/{i}.depth")), np.float32)
        depth = metres.reshape(depth_size[1], depth_size[0]) * np.float32(1000)
    except (*_DAMAGED, KeyError, OSError, ValueError) as error:
        raise BadInput(f"{path}: frame {i} cannot be read ({error}); the take was cut off there") from error
    if depth_size != size:
        depth = np.asarray(Image.fromarray(depth).resize(size, Image.Resampling.NEAREST))
    return RGBDFrame(color, np.ascontiguousarray(depth), time)


def _unpacked(packed: bytes) -> bytes:
    """lzfse tells damage by an exception of its own or by MemoryError.

    Raises:
        ValueError: damaged.
    """
    lzfse = _lzfse()
    try:
        return lzfse.decompress(packed)
    except (lzfse.error, MemoryError, RuntimeError) as error:
        raise ValueError(f"its depth is damaged ({error!r})") from error


def _lzfse():
    try:
        import lzfse
    except ImportError as error:
        raise BadInput("Record3D: the package lzfse is missing; pip install 'mien[record3d]'") from error
    return lzfse
