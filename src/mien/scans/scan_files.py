"""A folder of scans and which frame of the take each belongs to."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import BadInput
from ..files import existing
from ..io.meshes import read_scan
from ..mesh import Scan

SUFFIXES = (".ply", ".obj", ".stl", ".glb")


@dataclass(frozen=True)
class ScanFile:
    """A scan and its frame."""

    path: Path
    frame: int
    """Frame of the take, counted from 0."""

    @property
    def name(self) -> str:
        """The file's stem: what messages, targets and records call it."""
        return self.path.stem

    def read(self, unit: str | None = None) -> Scan:
        """The scan, in the file's own unit unless told.

        Raises:
            BadInput: as `read_scan`.
        """
        return read_scan(self.path, unit)


def match_scans(folder: str | Path, frames: tuple[int, ...], partial: bool = False) -> list[ScanFile]:
    """The scans of a folder in the order of `frames`, each by the number that ends its name or by `scans.json`.

    Args:
        frames: the selected frames.
        partial: go on without the frames that have no scan.

    Raises:
        BadInput: no scans, a name that ends in no number, a number that is no selected frame, two scans of a frame,
            frames without a scan.
    """
    folder = existing(folder)
    named = _named(folder)
    files = {}
    for path, frame in named:
        if frame not in frames:
            raise BadInput(
                f"{path}: frame {frame} is not among the selected ones ({_some(frames)}); rename it, or say in "
                f"{folder / 'scans.json'} which frame it is"
            )
        if frame in files:
            raise BadInput(f"{path}: frame {frame} has a scan already, {files[frame].name}; keep one of them")
        files[frame] = path
    missing = [frame for frame in frames if frame not in files]
    if missing and not partial:
        raise BadInput(
            f"{folder}: {len(missing)} of {len(frames)} selected frames have no scan: {_some(missing)}; scan them, or "
            "go on without them with --partial"
        )
    found = [ScanFile(files[frame], frame) for frame in frames if frame in files]
    if len(found) < 2:
        raise BadInput(f"{folder}: {len(found)} scan(s) of selected frames; 2 are needed")
    stems = [file.name for file in found]
    twice = next((name for name in stems if stems.count(name) > 1), None)
    if twice:
        raise BadInput(f"{folder}: two scans are called {twice}; give them different names")
    return found


def _named(folder: Path) -> list[tuple[Path, int]]:
    listing = folder / "scans.json"
    if listing.is_file():
        return _listed(listing)
    paths = sorted(p for p in folder.iterdir() if p.suffix.lower() in SUFFIXES and not p.name.startswith("."))
    if not paths:
        raise BadInput(f"{folder}: no scans in it; they are {', '.join(SUFFIXES)} files")
    found = []
    for path in paths:
        number = re.search(r"(\d+)$", path.stem)
        if number is None:
            raise BadInput(
                f"{path}: its name ends in no frame number (as in frame_000123.ply); rename it or list it in {listing}"
            )
        found.append((path, int(number.group(1))))
    return found


def _listed(listing: Path) -> list[tuple[Path, int]]:
    try:
        entries = json.loads(listing.read_text())
        found = [(listing.parent / name, frame) for name, frame in entries.items()]
        if not all(type(frame) is int for _, frame in found):
            raise TypeError
    except (json.JSONDecodeError, UnicodeDecodeError, AttributeError, TypeError):
        raise BadInput(f'{listing}: expected {{"smile.ply": 123, ...}}, a frame for each scan') from None
    for path, _ in found:
        existing(path)
    return found


def _some(frames) -> str:
    return ", ".join(map(str, frames[:8])) + (", ..." if len(frames) > 8 else "")
