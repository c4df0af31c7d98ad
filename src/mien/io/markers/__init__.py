"""Marker takes in: C3D, TRC, CSV."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ...clip import Markers
from ...errors import BadInput
from ...files import existing
from .c3d import read_c3d, write_c3d
from .marker_edits import apply_marker_edits, marker_edits_beside, read_marker_edits
from .marker_file import MarkerFile, RawTake, finish
from .tables import read_table, read_trc

READERS: dict[str, Callable[[Path], RawTake]] = {
    ".c3d": read_c3d,
    ".trc": read_trc,
    ".csv": read_table,
    ".tsv": read_table,
    ".txt": read_table,
}


def read_markers(
    path: str | Path, unit: str | None = None, rate: float | None = None, only: str | None = None
) -> Markers:
    """A marker take in millimetres; the `markers` of `read_marker_file`, which also tells what was assumed."""
    return read_marker_file(path, unit, rate, only).markers


def read_marker_file(
    path: str | Path,
    unit: str | None = None,
    rate: float | None = None,
    only: str | None = None,
    whole: bool = False,
    as_filed: bool = False,
) -> MarkerFile:
    """Read `.c3d`, `.trc`, `.csv`, `.tsv` or `.txt` and turn it into millimetres.

    Frames count from 0 at the first stored frame. A position that is not finite or exactly (0, 0, 0) is a gap. Labels
    that are never seen stay, all gaps. Unlabelled trajectories are left out; where fewer than six are labelled, those
    that last through half of the take are used, named by number. A label that comes twice is numbered. `subject:` is
    dropped where names stay different. Names and bad ranges of `take.markers.json` beside it count (`marker_edits`).
    Axes are the file's own, turned to +Y up only where the file names its up axis (C3D's POINT:Y_SCREEN; see
    `up_source`).

    Args:
        path: the take.
        unit: "mm", "cm", "m", "in" or millimetres in one unit as a number; overrides the file's. Where nobody says: the
            first of these that makes a face of the marker cloud, else the scale of a typical face (see `unit_source`).
        rate: frames a second; overrides the file's. Where nobody says: 30.
        whole: keep a body, a prop, a second actor, where a face stands among them; by default the face alone is read.
        only: read the markers that match this pattern alone, `Actor:*` or `face*,nose`, with or without their subject.
        as_filed: pass over what lies beside the take.

    Raises:
        BadInput: no such file, unknown suffix, not of that format, cut off, no points, fewer than six markers,
            no marker ever seen, a stated unit under which no markers are a face, nothing that matches `only`.
    """
    path = existing(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        kind = path.suffix or "a file without suffix"
        raise BadInput(f"{path}: cannot read {kind} as a marker take; give one of {' '.join(READERS)}")
    file = finish(path, reader(path), unit, rate, only, whole)
    return file if as_filed else _edited(path, file)


def _edited(path: Path, file: MarkerFile) -> MarkerFile:
    """With what a user said of its markers, if something lies beside it."""
    edits = read_marker_edits(path)
    if not len(edits):
        return file
    beside = marker_edits_beside(path)
    said = f"{beside}: {len(edits.names)} markers named, {len(edits) - len(edits.names)} ranges bad"
    return replace(file, markers=apply_marker_edits(file.markers, edits, beside), warnings=(*file.warnings, said))


__all__ = ["MarkerFile", "read_marker_file", "read_markers", "write_c3d"]
