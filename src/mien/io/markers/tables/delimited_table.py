"""Text tables as cells: encoding, delimiter, numbers with gaps. What every table of marker positions shares."""

import csv
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ....errors import BadInput
from ....text.decode_text import decode_text
from ....units import known_unit

_SPELLINGS = (
    "na n/a n.a. #n/a #na nan -nan nan(ind) -nan(ind) 1.#qnan -1.#qnan 1.#ind -1.#ind "
    "null none nil - -- ? inf -inf missing"
)
EMPTY = frozenset(["", *_SPELLINGS.split(" ")])
"""What programs write where a marker was not seen, in lower case."""

HEADER_ROWS = 12
"""Rows among which a header is looked for: Motive and Cortex write five to seven ahead of the numbers."""

DELIMITERS = ";\t,"
"""What parts cells; the first ones first, since decimals may bear commas."""
_FEWEST_DELIMITERS = 3
"""In one line of a table: a long table has five columns, a wide one more."""
_SECONDS = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
_CLOCK = re.compile(r"(\d+):(\d{1,2}):(\d{1,2}(?:[.,]\d+)?)")


@dataclass(frozen=True)
class DelimitedTable:
    """A table under its header."""

    path: Path
    columns: list[str]
    """Names in the file's spelling, units in brackets taken off."""
    units: list[str]
    """What stood in brackets, or in a row of units, for each column; "" for nothing."""
    rows: list[list[str]]
    row_numbers: list[int]
    """Line of each row in the file, from 1."""
    preamble: dict[str, str] = field(default_factory=dict)
    """Keys and values ahead of the header, keys in lower case."""

    def with_rows(self, keep: list[int]) -> "DelimitedTable":
        """Some of the rows."""
        rows, row_numbers = [self.rows[i] for i in keep], [self.row_numbers[i] for i in keep]
        return replace(self, rows=rows, row_numbers=row_numbers)

    def find(self, names: frozenset[str]) -> int | None:
        """The first column of one of these (lower-case) names."""
        return next((i for i, name in enumerate(self.columns) if name.lower() in names), None)

    def numbers(self, columns: list[int]) -> Float[np.ndarray, "rows columns"]:
        """Some columns as numbers, NaN for empty cells.

        Raises:
            BadInput: a cell that is neither a number nor empty, with its place.
        """
        cells = [[row[i] for i in columns] for row in self.rows]
        return cells_to_numbers(self.path, cells, self.row_numbers).reshape(len(self.rows), len(columns))

    def seconds(self, column: int) -> Float[np.ndarray, " rows"] | None:
        """A time column in seconds: numbers, or hh:mm:ss.fff; None where it holds neither (a time code)."""
        clock = [_CLOCK.fullmatch(row[column]) for row in self.rows]
        if clock and all(clock):
            parts = [[float(part.replace(",", ".")) for part in found.groups()] for found in clock if found]
            return np.array(parts) @ np.array([3600.0, 60.0, 1.0])
        try:
            return self.numbers([column])[:, 0] * _SECONDS.get(self.units[column].lower(), 1.0)
        except BadInput:
            return None

    def unit(self, columns: list[int]) -> float | None:
        """Millimetres in one unit of these columns, where the header or what precedes it says so."""
        stated = [self.units[i] for i in columns if self.units[i]]
        stated += [self.preamble[key] for key in ("length units", "units", "unit") if key in self.preamble]
        return known_unit(stated[0]) if stated else None


BLANK = " "
"""The delimiter where none stands in the first lines: runs of blanks part the cells."""


def read_cells(path: Path) -> tuple[list[list[str]], str]:
    """The cells of every line, stripped (a line without any is an empty list), and what parts them.

    Raises:
        BadInput: empty, binary, or a quote that is never closed.
    """
    text = decode_text(path).replace("\0", "")
    delimiter = sniff_delimiter(text)
    lines = text.splitlines()
    if delimiter == BLANK:
        rows = [line.split() for line in lines]
    else:
        try:
            rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
        except csv.Error as error:
            raise BadInput(f"{path}: not a table ({error}); is a quotation mark never closed?") from error
    rows = [row if any(row) else [] for row in rows]
    if not any(rows):
        raise BadInput(f"{path}: is empty")
    return rows, delimiter


def check_widths(path: Path, rows: list[list[str]], row_numbers: list[int], width: int) -> None:
    """Where blanks part the cells an empty cell cannot be seen: the others of its row would move up, unseen.

    Raises:
        BadInput: a row of another width.
    """
    for number, row in zip(row_numbers, rows, strict=True):
        if len(row) != width:
            raise BadInput(
                f"{path}: row {number} has {len(row)} cells for {width} columns, and where blanks part the cells "
                "nobody can tell which are missing; export it with tabs, or with NaN in the gaps"
            )


def cells_to_numbers(path: Path, rows: list[list[str]], row_numbers: list[int]) -> Float[np.ndarray, "rows columns"]:
    """Cells -> floats, NaN for gaps; decimal commas are understood.

    Raises:
        BadInput: a cell that is neither, with its row.
    """
    out = np.full((len(rows), len(rows[0]) if rows else 0), np.nan)
    for place, row in enumerate(rows):
        try:
            out[place] = [_number(cell) for cell in row]
        except ValueError:
            bad = next(cell for cell in row if not _is_cell_number(cell))
            what = f"{bad[:40]!r} is neither a number nor NA"
            raise BadInput(f"{path}: row {row_numbers[place]}: {what}; mend or empty it") from None
    return out


def sniff_delimiter(text: str) -> str:
    """The first of `DELIMITERS` that a line at the head of the file has often enough for a table of markers."""
    head = text.splitlines()[:HEADER_ROWS]
    for delimiter in DELIMITERS:
        if any(line.count(delimiter) >= _FEWEST_DELIMITERS for line in head):
            return delimiter
    return BLANK


def commonest_delimiter(text: str) -> str:
    """What parts the cells of a table of two columns or more: of `DELIMITERS` the one that `text` has most of."""
    return max(DELIMITERS, key=text.count)


def pad(row: list[str], width: int) -> list[str]:
    """A row brought to `width` cells."""
    return (row + [""] * (width - len(row)))[:width]


def is_number(cell: str) -> bool:
    """A number, perhaps with a decimal comma; an empty cell is none."""
    return cell.lower() not in EMPTY and _is_cell_number(cell)


def positive_number(text: str) -> float | None:
    """`text` as a number above 0, or None."""
    value = _number(text) if is_number(text) else 0.0
    return value if 0 < value < np.inf else None


def _is_cell_number(cell: str) -> bool:
    try:
        _number(cell)
    except ValueError:
        return False
    return True


def _number(cell: str) -> float:
    """ValueError where the cell is neither a number nor empty."""
    if cell.lower() in EMPTY:
        return float("nan")
    if "," not in cell:
        return float(cell)
    decimal = max(cell.rfind(","), cell.rfind("."))
    whole = cell[:decimal].replace(",", "").replace(".", "")
    return float(f"{whole}.{cell[decimal + 1 :]}")
