"""Record3D's `.r3d`: a zip of JPEG colour and LZFSE-compressed float32 depth in metres, from an iPhone or iPad."""

import json
import re
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path, PurePosixPath

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
_ABOUT = ("metadata", "metadata.json")
"""What the file with clock and camera is called."""
_MM = np.float32(1000)
"""Millimetres in Record3D's unit."""
_LZFSE = b"bvx"
"""How what LZFSE packed begins."""
_LISTED = 4
"""Files of the archive named in a message."""

_DAMAGED = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, SyntaxError)
"""What the packages that unpack zip archives and pictures raise on damaged ones."""
_WRONG = (KeyError, ValueError, TypeError, IndexError, AttributeError, OverflowError)
"""What metadata of another form raises."""


@dataclass(frozen=True)
class _Contents:
    """What an archive holds."""

    path: Path
    about: dict
    """Its metadata."""
    color: dict[int, str]
    """Frame -> name in the archive."""
    depth: dict[int, str]

    @property
    def numbers(self) -> list[int]:
        """Of the frames that are whole."""
        return sorted(self.color.keys() & self.depth.keys()) if self.depth else sorted(self.color)

    def notes(self) -> tuple[str, ...]:
        """What is missing, a line each."""
        if not self.depth:
            return (f"{self.path.name}: holds no depth; tracked from colour alone",)
        alone = len(self.color.keys() ^ self.depth.keys())
        line = f"{self.path.name}: {alone} colour or depth images have no partner and are left out"
        return (line,) if alone else ()


def read_record3d(path: Path) -> RgbdTake:
    """Open a Record3D recording.

    Raises:
        BadInput: not such a file, or the extra `record3d` is missing.
    """
    require("lzfse", "record3d")
    held = _contents(path)
    numbers, notes = held.numbers, held.notes()
    camera, depth_size = _camera(held, numbers[0])
    rate, times = _clock(path, held.about, numbers)

    def frames() -> Iterator[RGBDFrame]:
        with zipfile.ZipFile(path) as archive:
            for i, time in zip(numbers, times - times[:1], strict=True):
                yield _frame(held, archive, i, camera, depth_size, float(time))

    return RgbdTake(path.name, camera, rate, len(numbers), bool(held.depth), frames, notes=notes)


def _contents(path: Path) -> _Contents:
    """Metadata and frames, which may lie in a folder of the archive: some unpack a recording and pack it again.

    Raises:
        BadInput: no zip, or not Record3D's.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
            told = min((n for n in names if PurePosixPath(n).name in _ABOUT), key=len, default=None)
            text = b"" if told is None else archive.read(told)
    except (*_DAMAGED, KeyError, ValueError, OSError) as error:
        raise BadInput(f"{path}: not a whole Record3D recording ({error}); export it again") from error
    if told is None:
        raise BadInput(f"{path}: a zip, but not Record3D's: it holds no metadata, but {_listed(names)}; export .r3d")
    about = _json(path, text)
    inside = re.escape(told[: -len(PurePosixPath(told).name)])
    color, depth = (_numbered(names, rf"{inside}rgbd/(\d+)\.{kind}") for kind in ("(?:jpe?g|png)", "depth"))
    if not color or (depth and not color.keys() & depth.keys()):
        lacks = "no colour and depth of one frame" if color else "no colour as rgbd/0.jpg"
        raise BadInput(f"{path}: holds {lacks}, but {_listed(names)}; export .r3d from Record3D's library")
    return _Contents(path, about, color, depth)


def _json(path: Path, text: bytes) -> dict:
    try:
        about = json.loads(text)
    except ValueError as error:
        raise BadInput(f"{path}: its metadata is no JSON ({error}); export it again") from error
    if not isinstance(about, dict):
        raise BadInput(f"{path}: its metadata is no JSON object but a {type(about).__name__}; export it again")
    return about


def _numbered(names: Sequence[str], pattern: str) -> dict[int, str]:
    found = ((re.fullmatch(pattern, name, re.IGNORECASE), name) for name in names)
    return {int(match[1]): name for match, name in found if match}


def _listed(names: Sequence[str]) -> str:
    more = " ..." if len(names) > _LISTED else ""
    return ", ".join(sorted(names)[:_LISTED]) + more if names else "nothing at all"


def _clock(path: Path, about: dict, numbers: list[int]) -> tuple[float, np.ndarray]:
    """(rate, seconds of every frame); times that do not run forward are no clock, and the rate is."""
    try:
        rate = float(about.get("fps", 30))
        if not 0 < rate < np.inf:
            raise ValueError(f"fps {rate:g}")
        stamps, count = about.get("frameTimestamps") or [], max(numbers) + 1
        times = np.array(stamps if len(stamps) >= count else np.arange(count) / rate, float)[numbers]
        if times.shape != (len(numbers),) or not np.isfinite(times).all():
            raise ValueError("frameTimestamps are not one number a frame")
    except _WRONG as error:
        raise BadInput(f"{path}: its metadata tells no clock ({error}); export it again") from error
    return rate, times if (np.diff(times) > 0).all() else np.array(numbers) / rate


def _camera(held: _Contents, first: int) -> tuple[Camera, tuple[int, int] | None]:
    """The camera at the size that both images are brought to; width and height of the depth where the file says."""
    about = held.about
    try:
        if "w" in about and "h" in about:
            width, height = int(about["w"]), int(about["h"])
        else:
            with zipfile.ZipFile(held.path) as archive, Image.open(BytesIO(archive.read(held.color[first]))) as image:
                width, height = image.size
        known = "dw" in about and "dh" in about
        depth_size = (int(about["dw"]), int(about["dh"])) if known else None
        full = Camera(*_lens(about), width, height)
        if not (full.fx > 0 and full.fy > 0 and width > 0 and height > 0):
            raise ValueError(f"focal lengths {full.fx:g} and {full.fy:g}, {width} x {height} pixels")
    except (*_DAMAGED, *_WRONG, OSError) as error:
        raise BadInput(f"{held.path}: its metadata tells no camera (w, h and K): {error!r}; export it again") from error
    if depth_size and (width - height) * (depth_size[0] - depth_size[1]) < 0:
        depth_size = depth_size[1], depth_size[0]  # a phone held upright: the size is told as the sensor lies
    return full.scaled(min(1.0, LONGEST / max(width, height))), depth_size


def _lens(about: dict) -> tuple[float, float, float, float]:
    """fx, fy, cx, cy: of the matrix K, else the middle of what was noted with every frame (focus moves it)."""
    if "K" in about or not about.get("perFrameIntrinsicCoeffs"):
        return matrix_values(about["K"])
    fx, fy, cx, cy = np.median(np.array(about["perFrameIntrinsicCoeffs"], float)[:, :4], axis=0)
    return float(fx), float(fy), float(cx), float(cy)


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


def _frame(
    held: _Contents, archive: zipfile.ZipFile, i: int, camera: Camera, depth_size: tuple[int, int] | None, time: float
) -> RGBDFrame:
    size = (camera.width, camera.height)
    try:
        with Image.open(BytesIO(archive.read(held.color[i]))) as image:
            color = np.asarray(image.convert("RGB").resize(size, Image.Resampling.BOX))
        if not held.depth:
            return RGBDFrame(color, None, time)
        metres = _depth(archive.read(held.depth[i]), depth_size, size)
    except (*_DAMAGED, KeyError, OSError, ValueError) as error:
        raise BadInput(f"{held.path}: frame {i} cannot be read ({error}); the frames before it are good") from error
    return RGBDFrame(color, np.ascontiguousarray(resized(metres * _MM, (size[1], size[0]))), time)


def _depth(packed: bytes, depth_size: tuple[int, int] | None, size: tuple[int, int]) -> np.ndarray:
    """A depth image in metres, float32; also of 16-bit floats, and packed by nothing but the zip.

    Raises:
        ValueError: damaged, or not of that size.
    """
    told = depth_size[0] * depth_size[1] if depth_size else None
    bare = told is not None and len(packed) in (4 * told, 2 * told) and not packed.startswith(_LZFSE)
    plain = packed if bare else _unpacked(packed)
    half = told is not None and len(plain) == 2 * told
    metres = np.frombuffer(plain, np.float16 if half else np.float32).astype(np.float32)
    wide, high = depth_size or depth_shape(len(metres), *size)
    if len(metres) != wide * high:
        raise ValueError(f"{len(metres)} depths where its metadata says {wide} x {high}")
    return metres.reshape(high, wide)


def _unpacked(packed: bytes) -> bytes:
    """lzfse tells damage by an exception of its own or by MemoryError.

    Raises:
        ValueError: damaged.
    """
    lzfse = require("lzfse", "record3d")
    try:
        return lzfse.decompress(packed)
    except (lzfse.error, MemoryError, RuntimeError) as error:
        raise ValueError("its depth is damaged, or not packed by LZFSE") from error
