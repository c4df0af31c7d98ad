"""A folder of scans and which frame of the take each belongs to."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import BadInput
from ..files import existing
from ..io.meshes import read_scan
from ..mesh import Scan
from .left_out import LeftOut, enough, kept

Outcasts = tuple[LeftOut, ...]

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


def match_scans(folder: str | Path, frames: tuple[int, ...], strict: bool = False) -> tuple[list[ScanFile], Outcasts]:
    """The scans of a folder in the order of `frames`, each by the number that ends its name or by `scans.json`.

    Left out, each with its reason: a name that ends in no number, a number that is no selected frame, a second scan of
    a frame, a selected frame without a scan.

    Raises:
        BadInput: fewer than two scans are left, `scans.json` is none, or something is left out and `strict` forbids it.
    """
    folder = existing(folder)
    found, out = kept([_placed(file, frames, folder) for file in _named(folder)], strict)
    by_frame: dict[int, ScanFile] = {}
    doubles, names = [], set()
    for file in found:
        first = by_frame.get(file.frame)
        if first is not None:
            doubles.append(LeftOut(file.path.name, f"frame {file.frame} has a scan already, {first.path.name}"))
        elif file.name in names:
            doubles.append(LeftOut(file.path.name, "another scan has the same name; give it a different one"))
        else:
            by_frame[file.frame] = file
            names.add(file.name)
    missing = [frame for frame in frames if frame not in by_frame]
    absent = [LeftOut(f"selected frame {frame}", "it has no scan") for frame in missing]
    out = out + kept([*doubles, *absent], strict)[1]
    enough(len(by_frame), 2, out)
    return [by_frame[frame] for frame in frames if frame in by_frame], out


def read_scans(
    files: Sequence[ScanFile], unit: str | None, strict: bool = False
) -> tuple[list[ScanFile], list[Scan], Outcasts]:
    """The scans that can be read, with their files.

    Raises:
        BadInput: fewer than two can be read, or one cannot and `strict` forbids it.
    """
    read, out = kept([_read(file, unit) for file in files], strict)
    enough(len(read), 2, out)
    return [file for file, _ in read], [scan for _, scan in read], out


def _read(file: ScanFile, unit: str | None) -> tuple[ScanFile, Scan] | LeftOut:
    try:
        return file, replace(file.read(unit), name=file.name)
    except BadInput as error:
        return LeftOut(file.path.name, str(error))


def _placed(file: ScanFile | LeftOut, frames: tuple[int, ...], folder: Path) -> ScanFile | LeftOut:
    if isinstance(file, LeftOut) or file.frame in frames:
        return file
    return LeftOut(
        file.path.name,
        f"frame {file.frame} is not among the selected ones ({_some(frames)}); rename it, or say in "
        f"{folder / 'scans.json'} which frame it is",
    )


def _named(folder: Path) -> list[ScanFile | LeftOut]:
    listing = folder / "scans.json"
    if listing.is_file():
        return _listed(listing)
    paths = sorted(p for p in folder.iterdir() if p.suffix.lower() in SUFFIXES and not p.name.startswith("."))
    if not paths:
        raise BadInput(f"{folder}: no scans in it; they are {', '.join(SUFFIXES)} files")
    return [_numbered(path, listing) for path in paths]


def _numbered(path: Path, listing: Path) -> ScanFile | LeftOut:
    number = re.search(r"([0-9]+)$", path.stem)
    if number is None:
        return LeftOut(
            path.name,
            f"its name ends in no frame number (as in frame_000123.ply); rename it or list it in {listing}",
        )
    return ScanFile(path, int(number.group(1)))


def _listed(listing: Path) -> list[ScanFile | LeftOut]:
    try:
        entries = dict(json.loads(listing.read_text()))
    except (json.JSONDecodeError, UnicodeDecodeError, TypeError, ValueError):
        raise BadInput(f'{listing}: expected {{"smile.ply": 123, ...}}, a frame for each scan') from None
    return [_entry(listing, str(name), frame) for name, frame in entries.items()]


def _entry(listing: Path, name: str, frame: object) -> ScanFile | LeftOut:
    path = listing.parent / name
    if type(frame) is not int:
        return LeftOut(name, f"{listing} gives it {frame!r}; expected a frame, a whole number")
    if not path.is_file():
        return LeftOut(name, f"it is listed in {listing}, but there is no such file")
    return ScanFile(path, frame)


def _some(frames) -> str:
    return ", ".join(map(str, frames[:8])) + (", ..." if len(frames) > 8 else "")
