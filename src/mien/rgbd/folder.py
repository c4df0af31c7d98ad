"""The RGB-D folder: color/, depth/, camera_intrinsic.json; and a plain folder of colour images."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image

from ..camera import Camera
from ..depth import RGBDFrame
from ..errors import BadInput
from .intrinsics import assumed_camera, read_intrinsics
from .pairing import pair_images
from .take import RgbdTake
from .timestamps import read_timestamps

COLOR = ("color", "colour", "rgb", "image", "images")
DEPTH = ("depth", "depths", "depth_aligned", "aligned_depth")
INTRINSICS = ("camera_intrinsic.json", "camera_intrinsics.json", "intrinsic.json", "intrinsics.json", "camera.json")
"""What recorders call the parts of a take's folder; ours first."""
PICTURES = (".png", ".jpg", ".jpeg")
DEPTH_SCALE = 1000.0
RATE = 30.0
_ASPECT_SLACK = 0.02
"""Images whose aspect differs by less than this share show one view."""

T = TypeVar("T")


def read_folder(path: Path, depth_scale: float | None = None, rate: float | None = None) -> RgbdTake:
    """Open an RGB-D folder. Depth in units of 1 / `depth_scale` metres.

    Raises:
        BadInput: no intrinsics, no colour, colour and depth that do not belong together.
    """
    color, depth = pictures(part_of(path, COLOR)), pictures(part_of(path, DEPTH))
    if not color:
        raise BadInput(f"{path / 'color'}: no .png or .jpg images; landmarks need colour")
    paired = pair_images(path, color, depth)
    camera, notes = _camera_for(path, paired.color[0], paired.depth[0])
    settings = _settings(path / "take.json")
    scale = depth_scale or float(settings.get("depth_scale", DEPTH_SCALE))
    rate = rate or float(settings.get("fps", RATE))
    clock = path / "timestamps.csv"
    times = paired.numbers / rate if paired.seconds is None else paired.seconds
    if clock.is_file():
        times = read_timestamps(clock, paired.color, paired.numbers)

    def frames() -> Iterator[RGBDFrame]:
        for c, d, time in zip(paired.color, paired.depth, times, strict=True):
            image = picture(c)
            yield RGBDFrame(image, resized(depth_picture(d, scale), image.shape[:2]), float(time))

    notes = (*paired.notes, *notes)
    return RgbdTake(path.name, camera, rate, len(paired.color), True, frames, depth_scale=scale, notes=notes)


def read_images(path: Path, rate: float | None = None, focal: float | None = None) -> RgbdTake:
    """Open a folder of colour images, or one with color/ alone, as a take without depth.

    Raises:
        BadInput: no images.
    """
    inside = part_of(path, COLOR)
    color = pictures(inside if inside.is_dir() else path)
    if not color:
        raise BadInput(f"{path}: no color/ and depth/ folders, and no images either; this is not a take")
    height, width = picture(color[0]).shape[:2]
    intrinsics = part_of(path, INTRINSICS)
    known = intrinsics.is_file()
    size = (width, height)
    camera = read_intrinsics(intrinsics, size) if known else assumed_camera(*size, focal)
    rate = rate or RATE
    guessed = not known and focal is None
    notes = (f"{path}: no depth images; tracked from colour alone",)

    def frames() -> Iterator[RGBDFrame]:
        for i, file in enumerate(color):
            yield RGBDFrame(picture(file), None, i / rate)

    return RgbdTake(path.name, camera, rate, len(color), False, frames, guessed_camera=guessed, notes=notes)


def part_of(folder: Path, names: Sequence[str]) -> Path:
    """What a take's folder calls one of its parts, whatever its capitals; the first name where none is there."""
    there = {entry.name.lower(): entry for entry in sorted(folder.iterdir(), reverse=True)}
    return next((there[name] for name in names if name in there), folder / names[0])


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
        found = f"{values.dtype} of shape {values.shape}"
        raise BadInput(
            f"{path}: depth must be a 16-bit grey PNG, this is {found}: a picture of depth, not depth itself"
        )
    return values.astype(np.float32) * np.float32(1000.0 / scale)


def _read(path: Path, convert: Callable[[Image.Image], T]) -> T:
    try:
        with Image.open(path) as image:
            return convert(image)
    except (OSError, SyntaxError, ValueError) as error:
        raise BadInput(f"{path}: cannot be read to its end ({error}); the take was cut off there") from error


def resized(depth: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """A depth image at another size, each pixel the nearest one's depth (no depth is made up between two)."""
    if depth.shape == tuple(shape):
        return depth
    return np.asarray(Image.fromarray(depth).resize((shape[1], shape[0]), Image.Resampling.NEAREST))


def _camera_for(path: Path, color: Path, depth: Path) -> tuple[Camera, tuple[str, ...]]:
    """The camera of the colour images, and lines on sizes that had to be brought together.

    Raises:
        BadInput: the sizes show different views.
    """
    size = _read(color, lambda image: image.size)
    camera = read_intrinsics(part_of(path, INTRINSICS), size)
    others = {"depth": _read(depth, lambda image: image.size), "camera_intrinsic.json": (camera.width, camera.height)}
    sizes = {"colour": size, **others}
    (width, height), told = sizes["colour"], ", ".join(f"{name} {w} x {h}" for name, (w, h) in sizes.items())
    if any(abs(w * height - h * width) > _ASPECT_SLACK * w * height for w, h in sizes.values()):
        raise BadInput(f"{path}: sizes differ: {told}; register depth to colour and give that camera's intrinsics")
    if len(set(sizes.values())) == 1:
        return camera, ()
    scaled = replace(camera.scaled(width / camera.width), width=width, height=height)
    return scaled, (f"{path}: sizes differ: {told}; one view in each, all brought to the colour's",)


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
