"""Tables with a row for every marker and frame -> takes."""

from collections import Counter

import numpy as np
from jaxtyping import Float

from ....errors import BadInput
from ..marker_file import RawTake
from .delimited_table import DelimitedTable
from .frame_times import at_frames, place_rows
from .table_header import FRAME, LABEL, TIME, long_axes


def read_long(table: DelimitedTable) -> RawTake:
    """Columns frame (or time), label, x, y, z, rows in any order.

    A row that repeats another cell for cell is left out. A label that comes twice in most of its frames is two markers.

    Raises:
        BadInput: no frame or time; a row without; a label that comes twice in a few frames.
    """
    label_column, frame_column, time_column = table.find(LABEL), table.find(FRAME), table.find(TIME)
    key = frame_column if frame_column is not None else time_column
    axes = long_axes(table.columns)
    if key is None or label_column is None or axes is None:
        raise BadInput(f"{table.path}: a long table needs a frame or time column beside label, x, y, z")
    table, lines = _without_copies(table)
    keys = _keys(table, key)
    moments, first, which = np.unique(keys, return_index=True, return_inverse=True)
    labels, marker = _markers(table, [row[label_column] for row in table.rows], keys)
    positions = np.full((len(moments), len(labels), 3), np.nan)
    positions[which, marker] = table.numbers(axes)
    times = None if time_column is None else table.seconds(time_column)
    first_times = None if times is None else times[first]
    frames, rate, time_lines = place_rows(table, None if frame_column is None else moments, first_times)
    return RawTake(
        positions=at_frames(positions, frames),
        labels=tuple(labels),
        rate=rate,
        mm=table.unit(axes),
        warnings=(*lines, *time_lines),
    )


def _keys(table: DelimitedTable, column: int) -> Float[np.ndarray, " rows"]:
    """Frame number or time of every row."""
    is_time = table.columns[column].lower() in TIME
    keys = table.seconds(column) if is_time else table.numbers([column])[:, 0]
    if keys is None:
        raise BadInput(f"{table.path}: its column {table.columns[column]} holds no numbers; give seconds or frames")
    if not np.isfinite(keys).all():
        row = table.row_numbers[int(np.argmin(np.isfinite(keys)))]
        raise BadInput(f"{table.path}: row {row} has no {table.columns[column]}; fill it in or drop the row")
    return keys


def _without_copies(table: DelimitedTable) -> tuple[DelimitedTable, list[str]]:
    """Without rows that stand elsewhere cell for cell, and a line."""
    first = {tuple(row): i for i, row in reversed(list(enumerate(table.rows)))}
    keep = sorted(first.values())
    copies = len(table.rows) - len(keep)
    if not copies:
        return table, []
    return table.with_rows(keep), [f"{table.path}: {copies} rows repeat others and were left out"]


def _markers(table: DelimitedTable, names: list[str], keys: np.ndarray) -> tuple[list[str], np.ndarray]:
    """(labels, which of them each row is): the nth row of a name in a frame is the nth marker of that name."""
    nth = _occurrence(list(zip(names, keys, strict=True)))
    rows_of = Counter(zip(names, nth, strict=True))
    for row, (name, n) in enumerate(zip(names, nth, strict=True)):
        if n and 2 * rows_of[name, n] <= rows_of[name, 0]:
            raise BadInput(
                f"{table.path}: row {table.row_numbers[row]}: duplicate marker labels: {name} comes twice in frame "
                f"{keys[row]:g}; give every marker its own name"
            )
    place = {pair: i for i, pair in enumerate(sorted(rows_of, key=lambda pair: (names.index(pair[0]), pair[1])))}
    labels = [name for name, _ in place]
    return labels, np.array([place[pair] for pair in zip(names, nth, strict=True)], dtype=np.int64)


def _occurrence(pairs: list) -> list[int]:
    """How many equal ones stand before each."""
    count: Counter = Counter()
    out = []
    for pair in pairs:
        out.append(count[pair])
        count[pair] += 1
    return out
