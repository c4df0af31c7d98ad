"""Record3D's `.r3d`: a zip of JPEG colour and LZFSE-compressed float32 depth in metres, from an iPhone or iPad."""

import json
import zipfile
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
    except (zipfile.BadZipFile, KeyError, ValueError, OSError) as error:
        raise BadInput(f"{path}: not a whole Record3D recording ({error}); export it again") from error
    count = sum(1 for i in range(len(names)) if f"rgbd/{i}.depth" in names)
    camera, depth_size = _camera(path, about)
    rate = float(about.get("fps", 30))
    times = np.array(about.get("frameTimestamps") or np.arange(count) / rate, float)[:count]

    def frames() -> Iterator[RGBDFrame]:
        with zipfile.ZipFile(path) as archive:
            for i, time in enumerate(times - times[:1]):
                yield _frame(path, archive, i, camera, depth_size, float(time))

    return RgbdTake(path.name, camera, rate, count, True, frames)


def _camera(path: Path, about: dict) -> tuple[Camera, tuple[int, int]]:
    """The camera at the size that both images are brought to; width and height of the depth."""
    try:
        width, height, m = int(about["w"]), int(about["h"]), [float(value) for value in about["K"]]
        depth_size = (int(about.get("dw", width)), int(about.get("dh", height)))
        full = Camera(m[0], m[4], m[6], m[7], width, height)
    except (KeyError, ValueError, TypeError, IndexError) as error:
        raise BadInput(f"{path}: its metadata lacks w, h or K ({error!r}); export it again") from error
    return full.scaled(min(1.0, LONGEST / max(width, height))), depth_size


def _frame(path: Path, archive: zipfile.ZipFile, i: int, camera: Camera, depth_size, time: float) -> RGBDFrame:
    size = (camera.width, camera.height)
    try:
        with Image.open(BytesIO(archive.read(f"rgbd/{i}.jpg"))) as image:
            color = np.asarray(image.convert("RGB").resize(size, Image.Resampling.BOX))
        metres = np.frombuffer(_lzfse().decompress(archive.read(f"rgbd/{i}.depth")), np.float32)
        depth = metres.reshape(depth_size[1], depth_size[0]) * np.float32(1000)
    except (KeyError, OSError, ValueError, zipfile.BadZipFile, RuntimeError) as error:
        raise BadInput(f"{path}: frame {i} cannot be read ({error}); the take was cut off there") from error
    if depth_size != size:
        depth = np.asarray(Image.fromarray(depth).resize(size, Image.Resampling.NEAREST))
    return RGBDFrame(color, np.ascontiguousarray(depth), time)


def _lzfse():
    try:
        import lzfse
    except ImportError as error:
        raise BadInput("Record3D: the package lzfse is missing; pip install 'mien[record3d]'") from error
    return lzfse
