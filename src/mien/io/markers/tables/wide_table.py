"""Tables with a row a frame -> takes."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from ....errors import BadInput
from ..marker_file import RawTake
from .delimited_table import DelimitedTable
from .frame_times import at_frames, place_rows, repeated_rows
from .table_header import FRAME, TIME, MarkerColumns, marker_columns


def read_wide(table: DelimitedTable, ignored: frozenset[str] = frozenset()) -> RawTake:
    """Columns NAME_x, NAME_y, NAME_z; all others but frame, time and those `ignored` become notes."""
    return take_of(table, marker_columns(table.columns), ignored)


def take_of(
    table: DelimitedTable,
    markers: MarkerColumns,
    ignored: frozenset[str] | None = None,
    mm: float | None = None,
    rate: float | None = None,
    lines: Sequence[str] = (),
) -> RawTake:
    """The take of these marker columns; rows stand at their frame numbers or times.

    Args:
        table: a row a frame.
        markers: which columns are markers.
        ignored: names (lower case) of columns that are no notes; None: no column is.
        mm, rate: what the format says; where None, what the table says.
        lines: told with the take.
    """
    table, repeated = _without_repeated(table)
    columns = [column for _, at in markers for column in at]
    values = table.numbers(columns).reshape(len(table.rows), len(markers), 3)
    frame_column, time_column = table.find(FRAME), table.find(TIME)
    times = None if time_column is None else table.seconds(time_column)
    numbers = None if frame_column is None else table.numbers([frame_column])[:, 0]
    frames, found_rate, time_lines = place_rows(table, numbers, times)
    clock = {frame_column, None if times is None else time_column}
    others = [i for i, name in enumerate(table.columns) if name and i not in {*columns, *clock}]
    noted = [] if ignored is None else [i for i in others if table.columns[i].lower() not in ignored]
    return RawTake(
        positions=at_frames(values, frames),
        labels=tuple(label for label, _ in markers),
        rate=rate or found_rate,
        mm=mm or table.unit(columns),
        notes={table.columns[i]: _note(table, i, frames) for i in noted if len(table.rows)} or None,
        warnings=(*lines, *repeated, *time_lines),
    )


def _without_repeated(table: DelimitedTable) -> tuple[DelimitedTable, list[str]]:
    """Rows that repeat the one before, cell for cell, are left out where frames or times are named; and a line."""
    if table.find(FRAME) is None and table.find(TIME) is None:
        return table, []
    return repeated_rows(table)


def _note(table: DelimitedTable, column: int, frames: Int[np.ndarray, " rows"]) -> np.ndarray:
    """A further column, one value a frame: floats where all cells are numbers, else text; NaN or "" where no row is."""
    try:
        values = table.numbers([column])[:, 0]
        blank = np.full(frames[-1] + 1, np.nan)
    except BadInput:
        values = np.array([row[column] for row in table.rows])
        blank = np.full(frames[-1] + 1, "", dtype=values.dtype)
    blank[frames] = values
    return blank
