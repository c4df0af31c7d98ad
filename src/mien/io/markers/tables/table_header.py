"""Headers of tables of marker positions: which columns are a marker's x, y, z."""

import re
from pathlib import Path

from ....errors import BadInput
from ....units import known_unit
from .delimited_table import HEADER_ROWS, DelimitedTable, check_widths, is_number, pad

FRAME = frozenset(
    {"frame", "frame#", "frames", "frame number", "frame_number", "frame no", "field", "field #", "index"}
)
TIME = frozenset({"time", "seconds", "timestamp", "t"})
LABEL = frozenset(
    {"label", "marker", "name", "marker_name", "marker name", "markername", "point", "landmark"}
    | {"marker_id", "marker id", "markerid", "point_id", "landmark_id", "id"}
)
AXES = ("x", "y", "z")
_POSITION = r"(?:t|pos|position|coord|trans|translate|translation)[ _.:\-]*"
"""What some programs put ahead of the axis: `tx`, `pos_x`, `Position.X`."""

MarkerColumns = list[tuple[str, tuple[int, int, int]]]
"""(label, its x, y and z columns) of every marker."""

_BRACKET = re.compile(r"\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")
_TIME_UNIT = re.compile(r"^(time|timestamp|t)[ _]+(s|sec|seconds|ms|us|ns)$", re.IGNORECASE)
_LONG_TIME_UNITS = {"milliseconds": "ms", "microseconds": "us", "nanoseconds": "ns"}
_LENGTH_UNIT = re.compile(
    r"^(.*\b[xyz]|.*_[xyz]|.*[a-z0-9][XYZ])[ _]+(mm|cm|m|in|millimet(?:er|re)s?|met(?:er|re)s?)$", re.IGNORECASE
)
_SUFFIXED = re.compile(rf"^(.+?)[ _.:\-]+(?:{_POSITION})?([xyz])$", re.IGNORECASE)
_PREFIXED = re.compile(r"^([xyz])[ _.:\-]+(.+)$", re.IGNORECASE)
_LONG_AXIS = re.compile(rf"^(?:{_POSITION})?([xyz])(?:[ _]?pos(?:ition)?)?$", re.IGNORECASE)
_JOINED = re.compile(r"^(.*[a-z0-9])([XYZ])$")
_KEY_VALUE = re.compile(r"^[#%/ ]*([A-Za-z][\w ()]*?)\s*[:=]\s*(\S.*)$")
_FEWEST_AXES = 3
"""Cells x, y, z in a row that stands under a row of names."""


def table_under_header(path: Path, rows: list[list[str]], first_row: int = 1, blanks: bool = False) -> DelimitedTable:
    """The table of `rows` (the file's lines from line `first_row` on), whose header may follow a few rows of others.

    Args:
        blanks: blanks part the cells, so that an empty one does not show.

    Raises:
        BadInput: no header with marker columns; between blanks a row of another width than the header's.
    """
    filled = [(number, row) for number, row in enumerate(rows, start=first_row) if row]
    cells = [row for _, row in filled]
    for i in range(min(HEADER_ROWS, len(cells))):
        columns = _columns(cells, i, blanks)
        if columns is None:
            continue
        names, units = names_and_units(columns)
        start = i + 1
        if start < len(cells) and is_unit_row(cells[start]):
            units = [old or new.strip("[]()") for old, new in zip(units, pad(cells[start], len(units)), strict=True)]
            start += 1
        numbers = [number for number, _ in filled[start:]]
        if blanks:
            check_widths(path, cells[start:], numbers, len(names))
        return DelimitedTable(
            path=path,
            columns=names,
            units=units,
            rows=[pad(row, len(names)) for row in cells[start:]],
            row_numbers=numbers,
            preamble=read_preamble(cells[:i]),
        )
    raise BadInput(
        f"{path}: no marker columns in its header; expected frame,label,x,y,z or NAME_x,NAME_y,NAME_z for every marker"
    )


def is_long(columns: list[str]) -> bool:
    """One row a marker and frame, rather than one row a frame."""
    lower = {column.lower() for column in columns}
    return bool(lower & LABEL) and long_axes(columns) is not None


def long_axes(columns: list[str]) -> list[int] | None:
    """The columns of x, y and z where each row is one marker; None where one of them is missing."""
    found: dict[str, int] = {}
    for place, column in enumerate(columns):
        if named := _LONG_AXIS.match(column):
            found.setdefault(named[1].lower(), place)
    return [found[axis] for axis in AXES] if len(found) == len(AXES) else None


def marker_columns(columns: list[str]) -> MarkerColumns:
    """Every name that has all three of x, y, z (`NAME_x`, `NAME.X`, `x_NAME`, and where none is so, `nameX`).

    A name whose columns come twice is there twice.
    """
    for split in (_separated, _joined):
        found: dict[tuple[str, int], dict[str, int]] = {}
        times: dict[tuple[str, str], int] = {}
        for place, column in enumerate(columns):
            part = split(column)
            if part is None:
                continue
            nth = times[part] = times.get(part, 0) + 1
            found.setdefault((part[0], nth), {})[part[1]] = place
        whole = [(name, (at["x"], at["y"], at["z"])) for (name, _), at in found.items() if len(at) == len(AXES)]
        if whole:
            return whole
    return []


def names_and_units(cells: list[str]) -> tuple[list[str], list[str]]:
    """Header cells -> names, and the units that stood in brackets behind them."""
    names, units = [], []
    for cell in cells:
        bracket = _BRACKET.search(cell)
        name = cell[: bracket.start()] if bracket else cell
        unit = bracket[1] if bracket else ""
        if unit.lower() in AXES and name:
            name, unit = f"{name}_{unit}", ""
        if told := _TIME_UNIT.match(name) or _LENGTH_UNIT.match(name):
            name, unit = told[1], told[2]
        names.append(name)
        units.append(_LONG_TIME_UNITS.get(unit.lower(), unit))
    return names, units


def is_unit_row(row: list[str]) -> bool:
    """A row such as `s,mm,mm,mm`."""
    filled = [cell.strip("[]()") for cell in row if cell]
    known = [cell.lower() in ("s", "ms", "deg") or (known_unit(cell) and not is_number(cell)) for cell in filled]
    return len(filled) >= _FEWEST_AXES and all(known)


def read_preamble(rows: list[list[str]]) -> dict[str, str]:
    """Cells ahead of the header in pairs, as `key: value` or `# key = value`, or a lone number, which is the rate."""
    pairs: dict[str, str] = {}
    for row in rows:
        pairs.update({key.lower(): value for key, value in zip(row[::2], row[1::2], strict=False) if key and value})
        filled = [cell for cell in row if cell]
        pairs.update({found[1].lower(): found[2] for cell in filled if (found := _KEY_VALUE.match(cell))})
        if is_rate(row):
            pairs["rate"] = filled[0]
    return pairs


def is_rate(row: list[str]) -> bool:
    """A number that opens a row and stands alone there, but for its unit: `120` or `120,Hz`."""
    rest = {cell.lower() for cell in row[1:]}
    return bool(row) and is_number(row[0]) and rest <= {"", "hz"}


def _columns(rows: list[list[str]], i: int, blanks: bool) -> list[str] | None:
    """The column names if row `i` is the header, by itself or together with the row of names above it."""
    plain, _ = names_and_units(rows[i])
    axes = [cell.lower() in AXES for cell in plain]
    if sum(axes) < _FEWEST_AXES or is_long(plain):
        return rows[i] if is_long(plain) or marker_columns(plain) else None
    if i == 0:
        return None
    above = _over_first_axes(rows[i - 1], axes) if blanks else pad(rows[i - 1], len(plain))
    columns, name = [], ""
    for cell, title, is_axis in zip(rows[i], above, axes, strict=True):
        name = title or name
        columns.append(f"{name}_{cell}" if is_axis else cell or title)
    return columns if marker_columns(names_and_units(columns)[0]) else None


def _over_first_axes(names: list[str], axes: list[bool]) -> list[str]:
    """Names that blanks part, each over the first axis of its marker: the last of the row, as many as markers."""
    first = [place for place, is_axis in enumerate(axes) if is_axis][:: len(AXES)]
    above = [""] * len(axes)
    for place, name in zip(reversed(first), reversed(names), strict=False):
        above[place] = name
    return above


def _separated(column: str) -> tuple[str, str] | None:
    """`NAME_x` -> (NAME, "x"); None for a column that is no marker's coordinate."""
    if found := _SUFFIXED.match(column):
        return found[1], found[2].lower()
    if found := _PREFIXED.match(column):
        return found[2], found[1].lower()
    return None


def _joined(column: str) -> tuple[str, str] | None:
    found = _JOINED.match(column)
    return (found[1], found[2].lower()) if found else None
