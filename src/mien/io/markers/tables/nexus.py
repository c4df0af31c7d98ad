"""CSV of Vicon Nexus: sections one below the other, of which Trajectories are the markers."""

from pathlib import Path

from ....errors import BadInput
from ..marker_file import RawTake
from .delimited_table import is_number
from .table_header import table_under_header
from .wide_table import read_wide

_MARKERS = "trajectories"
_SECTIONS = (_MARKERS, "devices", "model outputs", "joints", "segments", "events", "force plates", "cameras", "objects")
_SUBFRAME = frozenset({"sub frame", "subframe", "sub_frame"})


def is_nexus(rows: list[list[str]]) -> bool:
    """A section of Nexus opens somewhere."""
    return bool(_sections(rows))


def read_nexus(path: Path, rows: list[list[str]]) -> RawTake:
    """The section Trajectories alone: its rate, names, axes, unit, frames.

    Raises:
        BadInput: there is none.
    """
    sections = _sections(rows)
    starts = [start for start, title in sections if title == _MARKERS]
    if not starts:
        titles = ", ".join(dict.fromkeys(title for _, title in sections))
        raise BadInput(f"{path}: has no section Trajectories, only {titles}; export the trajectories")
    start = starts[0]
    end = next((other for other, _ in sections if other > start), len(rows))
    table = table_under_header(path, rows[start + 1 : end], first_row=start + 2)
    return read_wide(table, ignored=_SUBFRAME)


def _sections(rows: list[list[str]]) -> list[tuple[int, str]]:
    """(row, title) of every section: a title alone in a row, and its rate alone in the next."""
    found = []
    for i, row in enumerate(rows):
        title = _lone(row).lower()
        if title in _SECTIONS and (title == "events" or is_number(_lone(rows[i + 1] if i + 1 < len(rows) else []))):
            found.append((i, title))
    return found


def _lone(row: list[str]) -> str:
    """The first cell of a row that has no other."""
    return row[0] if row and row[0] and not any(row[1:]) else ""
