"""TRC marker takes (Motion Analysis, OpenSim, Vicon)."""

import re
from itertools import pairwise
from pathlib import Path

from ....errors import BadInput
from ....text.decode_text import decode_text
from ....units import known_unit
from ..marker_file import RawTake
from .delimited_table import DelimitedTable, check_widths, is_number, pad, positive_number
from .table_header import MarkerColumns
from .wide_table import take_of

_LOOKED_AT = 20
"""Lines among which the header stands: five, unless blank ones or notes stand between."""
_AXIS = re.compile(r"x\d*", re.IGNORECASE)
_FRAME_AND_TIME = 2


def read_trc(path: Path) -> RawTake:
    """Header lines (keys, values, marker names, axes), then frame, time and x, y, z for every marker.

    TRC does not name its up axis.

    Raises:
        BadInput: not TRC, or a cell that is no number.
    """
    lines = decode_text(path).splitlines()
    names_at = next((i for i, line in enumerate(lines[:_LOOKED_AT]) if line.lower().startswith("frame")), None)
    if names_at is None:
        raise BadInput(f"{path}: not a TRC file; one of its first lines should start with Frame#")
    delimiter = _delimiter(lines[names_at])
    cells = [[cell.strip() for cell in line.split(delimiter)] for line in lines]
    body = [(number, row) for number, row in enumerate(cells, start=1) if number > names_at + 1 and _is_data(row)]
    header = _header(cells[:names_at])
    labels = _labels(cells[names_at], cells[names_at + 1] if names_at + 1 < len(cells) else [], header)
    columns = ["Frame", "Time", *(f"{label}_{axis}" for label, _ in labels for axis in "xyz")]
    if delimiter is None:
        check_widths(path, [row for _, row in body], [number for number, _ in body], len(columns))
    table = DelimitedTable(
        path=path,
        columns=columns,
        units=[""] * len(columns),
        rows=[pad(row, len(columns)) for _, row in body],
        row_numbers=[number for number, _ in body],
        preamble={key: header[key] for key in ("units", "datarate") if key in header},
    )
    return take_of(table, labels, mm=known_unit(header.get("units", "")))


def _delimiter(names: str) -> str | None:
    """Tabs where the line of names has any, commas or semicolons likewise, else blanks (None)."""
    return next((mark for mark in "\t;," if mark in names), None)


def _header(rows: list[list[str]]) -> dict[str, str]:
    """The line of keys that has DataRate, with the line of values under it."""
    for keys, values in pairwise(rows):
        lower = [key.lower() for key in keys]
        if "datarate" in lower:
            return dict(zip(lower, values, strict=False))
    return {}


def _labels(names: list[str], axes: list[str], header: dict[str, str]) -> MarkerColumns:
    """Marker names: as many as NumMarkers says, or those above X1, X2, ...; blank where one has no name."""
    found = [name for name in names[_FRAME_AND_TIME:] if name]
    above = [i for i, axis in enumerate(axes) if _AXIS.fullmatch(axis)]
    if len(found) != positive_number(header.get("nummarkers", "")) and above:
        found = [names[i] if i < len(names) else "" for i in above]
    return [(label, (at, at + 1, at + 2)) for label, at in zip(found, range(2, 2 + 3 * len(found), 3), strict=True)]


def _is_data(row: list[str]) -> bool:
    """A row that opens with a frame number (or a time, where that is missing)."""
    return any(row) and any(is_number(cell) for cell in row[:_FRAME_AND_TIME])
