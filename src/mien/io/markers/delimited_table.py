"""Text tables: delimiter, header, numbers with gaps, frame and time columns. What TRC and CSV reading share."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from ...errors import BadInput
from ..units import known_unit

EMPTY = {"", "na", "n/a", "nan", "null", "none", "-", "--", "inf", "-inf", "missing"}
FRAME = {"frame", "frame#", "frames", "frame number", "frame_number", "field", "field #", "index"}
TIME = {"time", "seconds", "timestamp", "t"}
LABEL = {"label", "marker", "name", "marker_name", "markername", "point", "landmark"}

_BRACKET = re.compile(r"\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")
_TIME_UNIT = re.compile(r"^(time|timestamp)[ _]+(s|sec|seconds|ms|us|ns)$", re.IGNORECASE)
_SUFFIXED = re.compile(r"^(.+?)[ _.:\-]+([xyz])$", re.IGNORECASE)
_PREFIXED = re.compile(r"^([xyz])[ _.:\-]+(.+)$", re.IGNORECASE)
_SECONDS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_HEADER_ROWS = 12


@dataclass(frozen=True)
class Sheet:
    """A table under its header."""

    path: Path
    columns: list[str]
    """Names in the file's spelling, units in brackets taken off."""
    units: list[str]
    """What stood in brackets, or in a row of units, for each column; "" for nothing."""
    rows: list[list[str]]
    comma: bool
    """Decimal commas may occur."""
    first_row: int
    """Row number, counted from 1, of `rows[0]` among the file's non-empty rows."""
    preamble: dict[str, str]
    """Keys and values ahead of the header, keys in lower case."""

    @property
    def long(self) -> bool:
        """One row a marker and frame, rather than one row a frame."""
        return _is_long(self.columns)

    def find(self, names: set[str]) -> int | None:
        """The first column of one of these (lower-case) names."""
        return next((i for i, name in enumerate(self.columns) if name.lower() in names), None)

    def numbers(self, columns: list[int]) -> Float[np.ndarray, "rows columns"]:
        """Some columns as numbers, NaN for empty cells.

        Raises:
            BadInput: a cell that is neither a number nor empty, with its place.
        """
        if not self.rows:
            return np.zeros((0, len(columns)))
        return numbers(self.path, [[row[i] for i in columns] for row in self.rows], self.comma, self.first_row)

    def seconds(self, column: int) -> Float[np.ndarray, " rows"] | None:
        """A time column in seconds; None where it does not hold plain numbers (a time code)."""
        try:
            return self.numbers([column])[:, 0] * _SECONDS.get(self.units[column].lower(), 1.0)
        except BadInput:
            return None

    def unit(self, columns: list[int]) -> float | None:
        """Millimetres in one unit of these columns, where the header or what precedes it says so."""
        stated = [self.units[i] for i in columns if self.units[i]] or [self.preamble.get("length units", "")]
        return known_unit(stated[0])


def read_sheet(path: Path) -> Sheet:
    """A delimited table and its header, which may follow a few rows of something else (Vicon, OptiTrack).

    Raises:
        BadInput: empty, not text, no header with marker columns.
    """
    text = read_text(path)
    delimiter = sniff_delimiter(text)
    rows = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines(), delimiter=delimiter)]
    rows = [row for row in rows if any(row)]
    if not rows:
        raise BadInput(f"{path}: is empty")
    for i in range(min(_HEADER_ROWS, len(rows))):
        columns = _columns(rows, i)
        if columns is None:
            continue
        names, units = _names_and_units(columns)
        start = i + 1
        if start < len(rows) and _is_unit_row(rows[start]):
            units = [old or new for old, new in zip(units, pad(rows[start], len(units)), strict=True)]
            start += 1
        body = [pad(row, len(names)) for row in rows[start:]]
        return Sheet(path, names, units, body, delimiter != ",", start + 1, _preamble(rows[:i]))
    raise BadInput(
        f"{path}: no marker columns in its header; expected frame,label,x,y,z or NAME_x,NAME_y,NAME_z for every marker"
    )


def triples(columns: list[str]) -> dict[str, tuple[int, int, int]]:
    """Marker name -> its x, y and z columns, for every name that has all three (`NAME_x`, `NAME.X`, `x_NAME`, ...)."""
    found: dict[str, dict[str, int]] = {}
    for i, column in enumerate(columns):
        part = marker_axis(column)
        if part is not None:
            found.setdefault(part[0], {}).setdefault(part[1], i)
    return {name: (at["x"], at["y"], at["z"]) for name, at in found.items() if len(at) == 3}


def marker_axis(column: str) -> tuple[str, str] | None:
    """`NAME_x` -> (NAME, "x"); None for a column that is no marker's coordinate."""
    if found := _SUFFIXED.match(column):
        return found[1], found[2].lower()
    if found := _PREFIXED.match(column):
        return found[2], found[1].lower()
    return None


def numbers(path: Path, rows: list[list[str]], comma: bool, first_row: int) -> Float[np.ndarray, "rows columns"]:
    """Cells -> floats, NaN for gaps; `comma` allows decimal commas.

    Raises:
        BadInput: a cell that is neither, with its row (`first_row` is that of `rows[0]`).
    """
    if comma:
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    try:
        values = [[np.nan if cell.lower() in EMPTY else float(cell) for cell in row] for row in rows]
    except ValueError:
        for i, row in enumerate(rows):
            bad = next((cell for cell in row if cell.lower() not in EMPTY and not _is_number(cell)), None)
            if bad is not None:
                message = f"{path}: row {first_row + i}: {bad!r} is neither a number nor NA"
                raise BadInput(message) from None
        raise
    return np.array(values, dtype=np.float64).reshape(len(rows), len(rows[0]) if rows else 0)


def read_text(path: Path) -> str:
    """The file as text, UTF-8 or else Latin-1.

    Raises:
        BadInput: binary.
    """
    data = path.read_bytes()
    if b"\0" in data[:4096]:
        raise BadInput(f"{path}: is binary, not a text table; does its suffix fit its content?")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def sniff_delimiter(text: str) -> str:
    """`;`, tab or `,`, whichever stands in the first lines; `;` and tab first, since decimals may bear commas."""
    head = text.splitlines()[:_HEADER_ROWS]
    for delimiter in ";\t,":
        if any(line.count(delimiter) >= 3 for line in head):
            return delimiter
    return " "


def pad(row: list[str], width: int) -> list[str]:
    """A row brought to `width` cells."""
    return (row + [""] * (width - len(row)))[:width]


def note(sheet: Sheet, column: int, frames: Int[np.ndarray, " rows"]) -> np.ndarray:
    """A further column, one value a frame: floats where all cells are numbers, else text; NaN or "" where no row is."""
    try:
        values = sheet.numbers([column])[:, 0]
        blank = np.full(frames[-1] + 1, np.nan)
    except BadInput:
        values = np.array([row[column] for row in sheet.rows])
        blank = np.full(frames[-1] + 1, "", dtype=values.dtype)
    blank[frames] = values
    return blank


def _columns(rows: list[list[str]], i: int) -> list[str] | None:
    """The column names if row `i` is the header, by itself or together with the row of names above it."""
    plain, _ = _names_and_units(rows[i])
    if _is_long(plain) or triples(plain):
        return rows[i]
    axes = [cell.lower() in ("x", "y", "z") for cell in plain]
    if sum(axes) < 3 or i == 0:
        return None
    above = next((row for row in rows[:i] if "name" in (cell.lower() for cell in row[:2])), rows[i - 1])
    above = pad(above, len(plain))
    columns, name = [], ""
    for cell, title, is_axis in zip(plain, above, axes, strict=True):
        name = title or name
        columns.append(f"{name}_{cell}" if is_axis else cell or title)
    return columns if triples(columns) else None


def _is_long(columns: list[str]) -> bool:
    lower = {column.lower() for column in columns}
    return bool(lower & LABEL) and {"x", "y", "z"} <= lower


def _names_and_units(cells: list[str]) -> tuple[list[str], list[str]]:
    names, units = [], []
    for cell in cells:
        bracket = _BRACKET.search(cell)
        name = cell[: bracket.start()] if bracket else cell
        unit = bracket[1] if bracket else ""
        if timed := _TIME_UNIT.match(name):
            name, unit = timed[1], timed[2]
        names.append(name)
        units.append(unit)
    return names, units


def _is_unit_row(row: list[str]) -> bool:
    filled = [cell for cell in row if cell]
    known = [cell.lower() in ("s", "ms", "deg") or (known_unit(cell) and not _is_number(cell)) for cell in filled]
    return len(filled) >= 3 and all(known)


def _preamble(rows: list[list[str]]) -> dict[str, str]:
    """Cells ahead of the header in pairs (OptiTrack), or a lone number, which is the rate (Vicon Nexus)."""
    pairs = {}
    for row in rows:
        pairs.update({key.lower(): value for key, value in zip(row[::2], row[1::2], strict=False) if key})
        filled = [cell for cell in row if cell]
        if len(filled) == 1 and _is_number(filled[0]):
            pairs["rate"] = filled[0]
    return pairs


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
