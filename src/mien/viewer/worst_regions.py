"""Regions of registered scans by how badly their details meet, worst first, from what `mien register` leaves."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import BadInput
from ..faces import load_face
from ..files import existing
from ..transforms import Transform

RECORD = ".register.json"
"""What `mien register SCANS/` writes beside its face."""


@dataclass(frozen=True)
class RegionMisfit:
    """A region of a scan."""

    name: str
    error: float
    """How far curvature is from the closest scans', 1/mm."""
    unreliable: bool
    """The registration does not trust itself there."""
    middle: tuple[float, float, float]
    """Scan space, mm."""


def is_record(path: Path) -> bool:
    """Whether a file is a registration's record, by its name."""
    return path.name.endswith(RECORD)


def read_regions(path: Path) -> dict[str, tuple[RegionMisfit, ...]]:
    """Regions of every scan, worst first; scans too, by their worst region.

    Raises:
        BadInput: no such file, or no record of a folder of scans.
    """
    return _read(path)[0]


def _read(path: Path) -> tuple[dict[str, tuple[RegionMisfit, ...]], str | None]:
    """The regions of every scan, and which scan rests, if the record says so."""
    try:
        told = json.loads(existing(path).read_text(encoding="utf-8"))
        found = {str(name): _regions(part) for name, part in told["scans"].items()}
        resting = told.get("markers", {}).get("resting")
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInput(f"{path}: is no record of registered scans ({error!r}); run `mien register` again") from error
    return dict(sorted(found.items(), key=lambda item: _badness(item[1][0]), reverse=True)), resting


def _badness(region: RegionMisfit) -> tuple[bool, float]:
    return region.unreliable, region.error


def _regions(part: Mapping[str, Any]) -> tuple[RegionMisfit, ...]:
    face, T = load_face(), part["T_face_scan"]
    T_face_scan = Transform(np.array(T["rotation"]), np.array(T["translation_mm"]), float(T["scale"]))
    regions = []
    for name, error in part["fine_error_per_mm"].items():
        weight = face.regions[name]
        middle = weight @ face.rig.neutral.vertices / weight.sum()
        x, y, z = T_face_scan.inverse().apply(middle[None])[0].round(2).tolist()
        regions.append(RegionMisfit(name, float(error), name in part["unreliable"], (x, y, z)))
    return tuple(sorted(regions, key=_badness, reverse=True))


def scans_to_mend(record: Path, folder: Path, suffixes: Sequence[str]) -> list[Path]:
    """Of a folder of scans the one with the worst region, and the resting one; the next worst where that is the same.

    Raises:
        BadInput: as `read_regions`, or these scans are not there.
    """
    regions, resting = _read(record)
    names = list(regions)
    others = sorted(names[1:], key=lambda name: name != resting)
    found = []
    for name in (names[0], *others[:1]):
        path = next((p for p in sorted(folder.iterdir()) if p.stem == name and p.suffix.lower() in suffixes), None)
        if path is None:
            raise BadInput(f"{folder}: holds no scan {name} that {record.name} tells of")
        found.append(path)
    return found
