"""The RGB-D folder: color/, depth/, camera_intrinsic.json; and a plain folder of colour images."""

import csv
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image

from ...camera import Camera
from ...depth import RGBDFrame
from ...errors import BadInput
from .intrinsics import assumed_camera, read_intrinsics
from .take import RgbdTake

PICTURES = (".png", ".jpg", ".jpeg")
DEPTH_SCALE = 1000.0
RATE = 30.0

T = TypeVar("T")


def read_folder(path: Path, depth_scale: float | None = None, rate: float | None = None) -> RgbdTake:
    """Open an RGB-D folder. Depth in units of 1 / `depth_scale` metres.

    Raises:
        BadInput: no intrinsics, no colour, colour and depth of different lengths or sizes.
    """
    camera = read_intrinsics(path / "camera_intrinsic.json")
    color, depth = pictures(path / "color"), pictures(path / "depth")
    if not color:
        raise BadInput(f"{path / 'color'}: no .png or .jpg images; landmarks need colour")
    if len(color) != len(depth):
        raise BadInput(
            f"{path}: {len(color)} colour and {len(depth)} depth images; a take needs one of each a frame, "
            f"remove those that have no partner after frame {min(len(color), len(depth)) - 1}"
        )
    settings = _settings(path / "take.json")
    scale = depth_scale or float(settings.get("depth_scale", DEPTH_SCALE))
    rate = rate or float(settings.get("fps", RATE))
    times = _timestamps(path / "timestamps.csv", len(color), rate)
    _check_size(path, color[0], depth[0], camera)

    def frames() -> Iterator[RGBDFrame]:
        for c, d, time in zip(color, depth, times, strict=True):
            yield RGBDFrame(picture(c), depth_picture(d, scale), float(time))

    return RgbdTake(path.name, camera, rate, len(color), True, frames, depth_scale=scale)


def read_images(path: Path, rate: float | None = None, focal: float | None = None) -> RgbdTake:
    """Open a folder of colour images, or one with color/ alone, as a take without depth.

    Raises:
        BadInput: no images.
    """
    color = pictures(path / "color" if (path / "color").is_dir() else path)
    if not color:
        raise BadInput(f"{path}: no color/ and depth/ folders, and no images either; this is not a take")
    height, width = picture(color[0]).shape[:2]
    known = (path / "camera_intrinsic.json").is_file()
    camera = read_intrinsics(path / "camera_intrinsic.json") if known else assumed_camera(width, height, focal)
    rate = rate or RATE

    def frames() -> Iterator[RGBDFrame]:
        for i, file in enumerate(color):
            yield RGBDFrame(picture(file), None, i / rate)

    return RgbdTake(path.name, camera, rate, len(color), False, frames, guessed_camera=not known and focal is None)


def pictures(folder: Path) -> list[Path]:
    """The images of a folder in the order of their names."""
    if not folder.is_dir():
        return []
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in PICTURES and not p.name.startswith("."))


def picture(path: Path) -> np.ndarray:
    """A colour image (h, w, 3) uint8.

    Raises:
        BadInput: it cannot be read to its end.
    """
    return _read(path, lambda image: np.asarray(image.convert("RGB")))


def depth_picture(path: Path, scale: float) -> np.ndarray:
    """A depth image in mm (h, w) float32; `scale` units a metre.

    Raises:
        BadInput: it cannot be read to its end, or is not 16-bit and grey.
    """
    values = _read(path, np.asarray)
    if values.ndim != 2 or values.dtype == np.uint8:
        raise BadInput(f"{path}: depth must be a 16-bit grey PNG, this is {values.dtype} of shape {values.shape}")
    return values.astype(np.float32) * np.float32(1000.0 / scale)


def _read(path: Path, convert: Callable[[Image.Image], T]) -> T:
    try:
        with Image.open(path) as image:
            return convert(image)
    except (OSError, SyntaxError, ValueError) as error:
        raise BadInput(f"{path}: cannot be read to its end ({error}); the take was cut off there") from error


def _check_size(path: Path, color: Path, depth: Path, camera: Camera) -> None:
    sizes = {
        "colour": _read(color, lambda image: image.size),
        "depth": _read(depth, lambda image: image.size),
        "camera_intrinsic.json": (camera.width, camera.height),
    }
    if len(set(sizes.values())) > 1:
        told = ", ".join(f"{name} {w} x {h}" for name, (w, h) in sizes.items())
        raise BadInput(f"{path}: sizes differ: {told}; register depth to colour and give that camera's intrinsics")


def _settings(path: Path) -> dict:
    if not path.is_file():
        return {}
    try:
        settings = json.loads(path.read_text())
        if not isinstance(settings, dict):
            raise TypeError(f"it holds a {type(settings).__name__}")
        bad = [k for k in ("depth_scale", "fps") if k in settings and not float(settings[k]) > 0]
    except (ValueError, TypeError, AttributeError) as error:
        raise BadInput(f"{path}: not a JSON object with depth_scale and fps ({error})") from error
    if bad:
        raise BadInput(f"{path}: {bad[0]} must be above 0, got {settings[bad[0]]}")
    return settings


def _timestamps(path: Path, count: int, rate: float) -> np.ndarray:
    if not path.is_file():
        return np.arange(count) / rate
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as file:
        lines = list(file)
    try:
        rows = list(csv.DictReader(lines))
        table = {int(row["frame"]): float(row["seconds"]) for row in rows}
        times = np.array([table[i] for i in range(count)])
    except (KeyError, ValueError, TypeError, OverflowError, csv.Error) as error:
        raise BadInput(f"{path}: needs columns frame,seconds, a row for each of {count} frames ({error!r})") from error
    grows = np.diff(times) > 0
    if not (grows.all() and np.isfinite(times).all()):
        raise BadInput(
            f"{path}: seconds must grow; they do not after frame {int(np.argmin(grows)) if len(grows) else 0}"
        )
    return times - times[0]
