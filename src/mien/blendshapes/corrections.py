"""What a user says of single captures by hand: landmarks, pinned points, and what is painted out (sec. 4.3).

`corrections.json`, beside the pictures that it names:

    {"smile": {"landmarks": {"61": [212, 340], "13": null}, "pins": {"mole": [180, 260]}, "mask": "smile_mask.png"}}

A capture is named as its file is. Landmarks bear MediaPipe's numbers; a place is a pixel (x, y) of the capture's map,
which is the texture that `mien scan -o smile.ply` writes; `null` drops one. A pin is a point of the skin that is no
landmark, such as a mole: where the neutral and a capture have a pin of one name, the warp goes through both. A mask is
a picture of the map's size: what is black is as if the sensor had seen nothing there.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ..errors import BadInput
from ..files import existing, whole
from ..flow import FlowConstraints
from ..io.meshes.images import read_image
from ..landmarks.detector import COUNT
from .correspond.landmarks import MapLandmarks, landmarks_on_map
from .correspond.occlusion import without
from .cylinder_map import CylinderLayout, CylinderMap

BLACK = 64
"""Grey values below this, of 255, are painted out."""


@dataclass(frozen=True)
class Correction:
    """Of one capture."""

    landmarks: Mapping[int, tuple[float, float] | None] = field(default_factory=dict)
    """Pixels (x, y) of the map by MediaPipe's number; None drops one."""
    painted: Bool[np.ndarray, "h w"] | None = None
    """Pixels that are painted out."""
    pins: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Pixels (x, y) of further points of the skin, by name."""


NOTHING = Correction()


def read_corrections(path: str | Path) -> dict[str, Correction]:
    """Corrections by the captures' names.

    Raises:
        BadInput: no such file, not the format above, a picture that cannot be read.
    """
    path = Path(path)
    try:
        told = json.loads(existing(path).read_text())
        return {name: _correction(path, part) for name, part in told.items()}
    except (ValueError, TypeError, AttributeError) as error:
        example = '{"smile": {"landmarks": {"61": [212, 340], "13": null}, "pins": {}, "mask": "smile.png"}}'
        raise BadInput(f"{path}: is not {example} ({error})") from None


def _correction(path: Path, part: dict[str, Any]) -> Correction:
    unknown = set(part) - {"landmarks", "mask", "pins"}
    if unknown:
        raise ValueError(f"unknown: {', '.join(sorted(unknown))}")
    places: dict[int, tuple[float, float] | None] = {}
    for number, place in part.get("landmarks", {}).items():
        if not 0 <= int(number) < COUNT:
            raise ValueError(f"landmark {number}: there are {COUNT}, counted from 0")
        places[int(number)] = None if place is None else (float(place[0]), float(place[1]))
    pins = {str(name): (float(place[0]), float(place[1])) for name, place in part.get("pins", {}).items()}
    if "mask" not in part:
        return Correction(places, None, pins)
    picture = read_image(path.parent / part["mask"])
    return Correction(places, picture.max(axis=2) < BLACK, pins)


def write_corrections(path: str | Path, told: Mapping[str, Any]) -> None:
    """Write the format above, whole or not at all.

    Raises:
        BadInput: it is not that.
    """
    with whole(path) as temporary:
        temporary.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        for part in told.values():
            _correction(Path(path), part)


def check_names(corrections: Iterable[str], captures: Sequence[str]) -> None:
    """Whether all corrections are of captures.

    Raises:
        BadInput: one is not.
    """
    strange = [name for name in corrections if name not in captures]
    if strange:
        raise BadInput(f"corrections of {', '.join(strange)}: no capture is called so; there are {', '.join(captures)}")


def without_painted(map_: CylinderMap, correction: Correction) -> CylinderMap:
    """The map with nothing where it was painted out.

    Raises:
        BadInput: a mask of another size.
    """
    painted = correction.painted
    if painted is None:
        return map_
    if painted.shape != map_.layout.shape:
        (h, w), (rows, columns) = map_.layout.shape, painted.shape
        raise BadInput(f"mask of {map_.name}: is {columns} x {rows} pixels; the map has {w} x {h}")
    return without(map_, painted)


def landmarks_by_hand(map_: CylinderMap, correction: Correction = NOTHING) -> MapLandmarks:
    """A map's landmarks, found, then added, moved and dropped as the correction says.

    Raises:
        BadInput: none is found and none is given, or one is given where the map shows nothing.
    """
    try:
        found = landmarks_on_map(map_)
    except BadInput:
        if not correction.landmarks:
            raise
        found = MapLandmarks(np.full((COUNT, 3), np.nan), np.zeros(COUNT, bool))
    points = {}
    for number, place in correction.landmarks.items():
        points[number] = None if place is None else map_.at(np.array([place]))[0][0].astype(np.float64)
        if points[number] is not None and not np.isfinite(points[number]).all():
            raise BadInput(f"{map_.name}: landmark {number} at {place} by hand: the map shows nothing there")
    return found.edited(points)


Pins = Mapping[str, Float[np.ndarray, " 3"]]
"""Points of the skin by name, face space, mm."""


def pins_by_hand(map_: CylinderMap, correction: Correction) -> Pins:
    """A map's pins.

    Raises:
        BadInput: one lies where the map shows nothing.
    """
    pins = {}
    for name, place in correction.pins.items():
        point = map_.at(np.array([place]))[0][0].astype(np.float64)
        if not np.isfinite(point).all():
            raise BadInput(f"{map_.name}: pin {name} at {place}: the map shows nothing there")
        pins[name] = point
    return pins


def pinned(neutral: Pins, source: Pins, layout: CylinderLayout) -> FlowConstraints | None:
    """Pins that both have, from the neutral's map to the source's, pixels; None where there are none."""
    both = [name for name in neutral if name in source]
    if not both:
        return None
    here, there = (layout.pixels(np.stack([pins[name] for name in both])) for pins in (neutral, source))
    return FlowConstraints(here, there)
