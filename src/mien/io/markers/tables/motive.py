"""CSV of OptiTrack's Motive: columns of markers among those of rigid bodies, bones and their errors."""

import re
from pathlib import Path

from ..marker_file import RawTake
from .delimited_table import DelimitedTable, pad
from .table_header import AXES, MarkerColumns, names_and_units, read_preamble
from .wide_table import take_of

_MARKER_TYPES = ("marker", "unlabeled marker", "unlabelled marker", "labeled marker", "labelled marker")
_SOLVED_TYPES = ("rigid body marker", "bone marker")
"""Where the solved body says that a marker is: a second copy of the marker of its name."""
_KEYS = ("type", "name", "id", "parent", "asset type")
_POSITION = ("", "position")
_LOOKED_AT = 20
"""Rows among which the header ends."""
_NUMBERED = re.compile(r"[\s:_\-]*(marker)?[\s:_\-]*\d+$", re.IGNORECASE)


def is_motive(rows: list[list[str]]) -> bool:
    """A row of types stands ahead of the numbers, or the first line names the format's version."""
    first = next((row for row in rows if row), [""])
    return first[0].lower() == "format version" or any(_key(row) == "type" for row in rows[:_LOOKED_AT])


def read_motive(path: Path, rows: list[list[str]]) -> RawTake | None:
    """The columns of type Marker; rotations, bones, errors and the markers that bodies repeat are left out.

    Of a body none of whose markers stands among the columns of type Marker, its own markers are read. None: no header
    of Motive after all.
    """
    axes = next((i for i, row in enumerate(rows[:_LOOKED_AT]) if row and row[0].lower() == "frame"), None)
    if axes is None:
        return None
    names, units = names_and_units(rows[axes])
    header = {_key(row): pad(row, len(names)) for row in rows[:axes] if row}
    if "name" not in header:
        return None
    markers, left_out = _marker_columns(names, header)
    table = DelimitedTable(
        path=path,
        columns=names,
        units=units,
        rows=[pad(row, len(names)) for row in rows[axes + 1 :] if row],
        row_numbers=[number for number, row in enumerate(rows[axes + 1 :], start=axes + 2) if row],
        preamble=read_preamble([row for row in rows[:axes] if row and _key(row) not in _KEYS]),
    )
    lines = [f"{path}: {left_out} markers of rigid bodies or bones repeat others and were left out"] if left_out else []
    return take_of(table, markers, lines=lines)


def _marker_columns(names: list[str], header: dict[str, list[str]]) -> tuple[MarkerColumns, int]:
    """(columns of the markers, how many copies were left out)."""
    blank = [""] * len(names)
    quantities = header.get("", blank)
    turning = {name for name, what in zip(header["name"], quantities, strict=True) if what.lower() == "rotation"}
    types = header.get("type", ["rigid body" if name in turning else "marker" for name in header["name"]])
    found = _triples(names, header["name"], header.get("id", blank), quantities)
    markers = [(label, at) for label, at in found if types[at[0]].lower() in _MARKER_TYPES]
    solved = [(label, at) for label, at in found if types[at[0]].lower() in _SOLVED_TYPES]
    labels = {label for label, _ in markers}
    bodies = {_body(label) for label in labels}
    alone = [(label, at) for label, at in dict(solved).items() if label not in labels and _body(label) not in bodies]
    return markers + alone, len(solved) - len(alone)


def _triples(axes: list[str], labels: list[str], ids: list[str], quantities: list[str]) -> MarkerColumns:
    """Every X, Y, Z in a row that are positions under one name."""
    found = []
    for i in range(len(axes) - 2):
        three = slice(i, i + 3)
        is_xyz = tuple(axis.lower() for axis in axes[three]) == AXES
        is_position = all(quantity.lower() in _POSITION for quantity in quantities[three])
        if is_xyz and is_position and len(set(zip(labels[three], ids[three], strict=True))) == 1:
            found.append((labels[i], (i, i + 1, i + 2)))
    return found


def _body(label: str) -> str:
    """`Head:Marker 001`, `Head_Marker1`, `Head-1` -> head."""
    return (label.split(":")[0] if ":" in label else _NUMBERED.sub("", label)).lower()


def _key(row: list[str]) -> str:
    """What a header row is of: "type", "name", ...; "" for the row of quantities."""
    first = next((cell.lower() for cell in row[:2] if cell), "")
    return first if first in _KEYS or (row and row[0]) else ""
