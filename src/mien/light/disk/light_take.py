"""A folder of active-light pictures: patterns.json, calibration.json, and one folder of pictures a camera."""

import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from PIL import Image, UnidentifiedImageError

from ...errors import BadInput
from ...files import existing
from ...pictures.color import to_linear
from ..light_rig import LightRig, read_rig
from ..patterns import LightPattern, PatternSet, read_patterns

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
PATTERNS = "patterns.json"
DARK, BRIGHT = 0.02, 0.98
"""Of full scale: a picture that is darker almost everywhere, or brighter over most of what is lit, is of no use."""


@dataclass(frozen=True)
class LightTake:
    """Captures of one rig, read one by one."""

    patterns: PatternSet
    rig: LightRig
    pictures: dict[str, tuple[Path, ...]]
    """By camera, in their order; a capture after the other."""

    def __len__(self) -> int:
        return len(next(iter(self.pictures.values()))) // len(self.patterns)

    def capture(self, number: int) -> dict[str, Float[np.ndarray, "slots h w"]]:
        """One capture's pictures by camera, linear 0..1.

        Raises:
            BadInput: a picture that cannot be read, of another size, doubled, or all dark or saturated.
        """
        first = number * len(self.patterns)
        out = {}
        for name, paths in self.pictures.items():
            images = [read_grey(path, self.rig.gamma) for path in paths[first : first + len(self.patterns)]]
            told = paths[first : first + len(self.patterns)]
            one_size(images, told)
            _exposed(images, told, self.patterns)
            _no_double(images, told, self.patterns)
            out[name] = np.stack(images)
        return out

    def __iter__(self) -> Iterator[dict[str, Float[np.ndarray, "slots h w"]]]:
        return (self.capture(number) for number in range(len(self)))


def read_light_take(folder: str | Path, calibration: str | Path | None = None) -> LightTake:
    """Open a folder; `calibration` stands in for its own. What it lacks is taken from the folder above it.

    Raises:
        BadInput: no such folder, no patterns, no calibration, no pictures, or numbers that do not come out even.
    """
    folder = existing(folder)
    if not folder.is_dir():
        raise BadInput(
            f"{folder}: expected a folder with patterns.json, calibration.json and a folder of pictures a camera"
        )
    patterns = read_patterns(_own_or_shared(folder, PATTERNS))
    rig = read_rig(calibration or _own_or_shared(folder, "calibration.json"))
    pictures = {view.name: pictures_of(folder / view.name) for view in rig.cameras if (folder / view.name).is_dir()}
    if not pictures:
        raise BadInput(
            f"{folder}: no folder of any camera of the calibration ({', '.join(v.name for v in rig.cameras)})"
        )
    strangers = sorted(p for p in folder.iterdir() if p.is_dir() and p.name not in pictures and pictures_of(p))
    if strangers:
        raise BadInput(
            f"{strangers[0]}: pictures of no camera of the calibration ({', '.join(v.name for v in rig.cameras)}); "
            "name the folder after one, take it away, or give the calibration of these cameras"
        )
    for name, paths in pictures.items():
        if not paths or len(paths) % len(patterns):
            raise BadInput(f"{folder / name}: {len(paths)} pictures, {len(patterns)} slots a capture{_gap(paths)}")
    counts = {name: len(paths) // len(patterns) for name, paths in pictures.items()}
    if len(set(counts.values())) != 1:
        raise BadInput(f"{folder}: cameras with different numbers of captures: {counts}")
    return LightTake(patterns, rig, pictures)


def _own_or_shared(folder: Path, name: str) -> Path:
    """A file of the folder, or of the one above it, which several takes share."""
    for place in (folder / name, folder.parent / name):
        if place.is_file():
            return place
    made = "`mien decode --show paper`" if name == PATTERNS else "`mien decode POSES/ --board 9x7x75`"
    raise BadInput(f"{folder}: no {name} in it or beside it; {made} writes one")


def pictures_of(folder: Path) -> tuple[Path, ...]:
    """Pictures in the order of the numbers in their names."""
    found = [path for path in folder.iterdir() if path.suffix.lower() in PICTURES]
    return tuple(sorted(found, key=_number))


def _number(path: Path) -> tuple[list[int], str]:
    return [int(digits) for digits in re.findall(r"\d+", path.stem)], path.name


def _gap(paths: tuple[Path, ...]) -> str:
    """What the numbers in the names say is missing or too much."""
    numbers = [_number(path)[0][-1] for path in paths if _number(path)[0]]
    if len(numbers) != len(paths) or not numbers:
        return ": a picture is missing or doubled"
    missing = sorted(set(range(min(numbers), max(numbers) + 1)) - set(numbers))
    if missing:
        return f": number {missing[0]} is missing"
    return f": the last, {paths[-1].name}, is one too many or the first of a capture that was cut off"


def read_grey(path: Path, gamma: float = 1.0) -> Float[np.ndarray, "h w"]:
    """A picture as linear grey, 0..1, of 8 or 16 bits; colours are averaged.

    Args:
        gamma: of the stored values; 2.2 stands for sRGB's own curve.

    Raises:
        BadInput: no picture.
    """
    try:
        with Image.open(path) as picture:
            values = np.array(picture if picture.mode != "P" else picture.convert("RGB"))
    except (OSError, UnidentifiedImageError, ValueError) as error:
        raise BadInput(f"{path}: cannot be read as a picture ({error})") from None
    scale = 1.0 if values.dtype == bool else 255.0 if values.dtype == np.uint8 else 65535.0
    stored = values[..., :3].mean(axis=-1) / scale if values.ndim == 3 else values / scale
    if gamma == 1.0:
        return stored.astype(float)
    return to_linear(stored) if abs(gamma - 2.2) < 0.05 else stored**gamma


def one_size(images: list[np.ndarray], paths: tuple[Path, ...]) -> None:
    """Refuse pictures of several sizes.

    Raises:
        BadInput: the first that differs.
    """
    for image, path in zip(images, paths, strict=True):
        if image.shape != images[0].shape:
            (h, w), (height, width) = image.shape, images[0].shape
            raise BadInput(f"{path}: {w} x {h} pixels, the capture's others {width} x {height}")


def _no_double(images: list[np.ndarray], paths: tuple[Path, ...], patterns: PatternSet) -> None:
    """Sensors have noise: two pictures alike to the last bit are one, stored twice, unless they show the same light."""
    seen: dict[int, int] = {}
    for i, image in enumerate(images):
        first = seen.setdefault(zlib.crc32(image.tobytes()), i)
        if shown(patterns, i) != shown(patterns, first) and np.array_equal(image, images[first]):
            raise BadInput(
                f"{paths[i]}: the same picture as {paths[first].name}; one is doubled, so the slots do not fit"
            )


def shown(patterns: PatternSet, slot: int) -> LightPattern:
    """The slot's light; the tracking frame has the constant condition's."""
    pattern = patterns.patterns[slot]
    return LightPattern("constant") if pattern.kind == "tracking" else pattern


def _exposed(images: list[np.ndarray], paths: tuple[Path, ...], patterns: PatternSet) -> None:
    """Every slot but Gray codes, ramps and black shows light somewhere; the brightest ones are not saturated by it."""
    for slot in patterns.of("full", "constant", "tracking", "sinusoid", "gradient"):
        kind = patterns.patterns[slot].kind
        if np.quantile(images[slot], 0.995) < DARK:
            raise BadInput(f"{paths[slot]}: black, where {kind} light should be; wrong order, or no light")
    for slot in patterns.of("full", "constant"):
        lit = images[slot][images[slot] > np.quantile(images[slot], 0.995) / 2]
        if (lit > BRIGHT).mean() > 0.5:
            raise BadInput(f"{paths[slot]}: saturated over half of what is lit; lower the exposure")
