"""CSV of Vicon Nexus: sections one below the other, of which Trajectories are the markers."""

from itertools import pairwise
from pathlib import Path

from ....errors import BadInput
from ..marker_file import RawTake
from .table_header import is_rate, table_under_header
from .wide_table import read_wide

_MARKERS = "trajectories"
_SECTIONS = frozenset(
    {
        _MARKERS,
        "devices",
        "analog",
        "model outputs",
        "angles",
        "forces",
        "moments",
        "powers",
        "joints",
        "segments",
        "events",
        "force plates",
        "cameras",
        "objects",
        "parameters",
    }
)
_WITHOUT_RATE = ("events", "parameters")
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
    """(row, title) of every section: a title alone in a row, and its rate in the next (`120`, of old `120,Hz`)."""
    found = []
    for i, (row, after) in enumerate(pairwise([*rows, []])):
        title = _lone(row).lower()
        if title in _SECTIONS and (title in _WITHOUT_RATE or is_rate(after)):
            found.append((i, title))
    return found


def _lone(row: list[str]) -> str:
    """The first cell of a row that has no other."""
    return row[0] if row and row[0] and not any(row[1:]) else ""
