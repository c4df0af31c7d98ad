"""TSV of Qualisys Track Manager: keys and values, then rows of positions; column names and times are options."""

from pathlib import Path

from ....errors import BadInput
from ..marker_file import RawTake
from .delimited_table import DelimitedTable, is_number, pad, positive_number
from .table_header import MarkerColumns
from .wide_table import take_of

_MM = 1.0
"""Track Manager exports millimetres, whatever it shows."""
_KEYS = ("NO_OF_FRAMES", "NO_OF_MARKERS", "MARKER_NAMES", "FREQUENCY", "DATA_INCLUDED", "BODY_NAMES", "NO_OF_BODIES")
_FEWEST_KEYS = 2


def is_qualisys(rows: list[list[str]]) -> bool:
    """Two of the header's keys stand at the start."""
    keys = {row[0].upper() for row in rows[:30] if row}
    return sum(key in keys for key in _KEYS) >= _FEWEST_KEYS


def read_qualisys(path: Path, rows: list[list[str]]) -> RawTake:
    """Positions of a 3D export, in millimetres.

    Raises:
        BadInput: bodies (6D) instead of markers, no names, columns that do not fit the names.
    """
    header = {row[0].upper(): row[1:] for row in rows if row and not is_number(row[0])}
    if "BODY_NAMES" in header or "6D" in header.get("DATA_INCLUDED", []):
        raise BadInput(f"{path}: holds rigid bodies (6D), no markers; export 3D data from Track Manager")
    body = [(number, row) for number, row in enumerate(rows, start=1) if row and _is_data(row)]
    if not body:
        raise BadInput(f"{path}: has no marker points (no row of numbers); export it again")
    labels = _labels(path, header, body[0][1])
    table, markers = _laid_out(path, labels, body)
    rate = positive_number(next(iter(header.get("FREQUENCY", [])), ""))
    return take_of(table, markers, mm=_MM, rate=rate)


def _labels(path: Path, header: dict[str, list[str]], first: list[str]) -> list[str]:
    """MARKER_NAMES, "" for markers that it leaves out."""
    names = header.get("MARKER_NAMES", [])
    while names and not names[-1]:
        names = names[:-1]
    stated = positive_number(next(iter(header.get("NO_OF_MARKERS", [])), ""))
    count = int(stated) if stated and stated < len(first) else len(names)
    if max(count, len(names)) == 0:
        raise BadInput(f"{path}: has no marker points (MARKER_NAMES is empty); export labelled markers")
    return names + [""] * (count - len(names))


def _laid_out(path: Path, labels: list[str], body: list[tuple[int, list[str]]]) -> tuple[DelimitedTable, MarkerColumns]:
    """Rows cut to frame, time (where there) and three columns a marker."""
    width = 3 * len(labels)
    widest = max(len(row) for _, row in body)
    cells = [pad(row, widest) for _, row in body]
    trailing = widest > width and not any(row[-1] for row in cells) and any(row[-2] for row in cells)
    ahead = widest - trailing - width
    if not 0 <= ahead <= 2:
        raise BadInput(f"{path}: {widest} columns for {len(labels)} markers; expected {width}, and frame and time")
    firsts = {0: [], 1: ["time" if _fractions(cells) else "frame"], 2: ["frame", "time"]}[ahead]
    columns = [*firsts, *(f"{label}_{axis}" for label in labels for axis in "xyz")]
    rows = [row[: len(columns)] for row in cells]
    markers = [(label, (at, at + 1, at + 2)) for label, at in zip(labels, range(ahead, len(columns), 3), strict=True)]
    return DelimitedTable(path, columns, [""] * len(columns), rows, [number for number, _ in body]), markers


def _fractions(cells: list[list[str]]) -> bool:
    """Does the first column hold times rather than frame numbers?"""
    return any("." in row[0] or "," in row[0] for row in cells)


def _is_data(row: list[str]) -> bool:
    """All its filled cells are numbers."""
    return is_number(next((cell for cell in row if cell), "")) and (is_number(row[0]) or not row[0])
