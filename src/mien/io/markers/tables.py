"""Marker takes as text: TRC, and CSV or TSV in long, wide and two-row forms."""

from collections import Counter
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from ...errors import BadInput
from ..units import known_unit
from .delimited_table import FRAME, LABEL, TIME, Sheet, marker_axis, note, numbers, pad, read_sheet, read_text, triples
from .frame_times import frames_of_numbers, frames_of_times, rate_of, spread
from .marker_file import RawTake


def read_trc(path: Path) -> RawTake:
    """A TRC file (Motion Analysis, OpenSim, Vicon): five header lines, then frame, time and x, y, z for every marker.

    TRC does not name its up axis.

    Raises:
        BadInput: not TRC, or a cell that is no number.
    """
    lines = read_text(path).splitlines()
    if len(lines) < 5 or not lines[0].startswith("PathFileType"):
        raise BadInput(f"{path}: not a TRC file; its first line should start with PathFileType")
    tabs = "\t" in lines[3]
    cells = [[cell.strip() for cell in (line.split("\t") if tabs else line.split())] for line in lines]
    header = dict(zip((key.lower() for key in cells[1]), cells[2], strict=False))
    labels = [label for label in cells[3][2:] if label]
    rows = [pad(row, 2 + 3 * len(labels)) for row in cells[5:] if any(row)]
    values = numbers(path, rows, comma=False, first_row=6).reshape(len(rows), 2 + 3 * len(labels))
    frames = frames_of_numbers(path, values[:, 0])
    rate = header.get("datarate", "")
    return _take(
        labels=labels,
        positions=spread(values[:, 2:].reshape(len(rows), len(labels), 3), frames),
        rate=float(rate) if known_unit(rate) else rate_of(values[:, 1], frames),
        mm=known_unit(header.get("units", "")),
    )


def read_csv(path: Path) -> RawTake:
    """A table of marker positions with a header.

    Long: columns frame (or time), label (or marker, name), x, y, z. Wide: a row a frame and columns NAME_x, NAME_y,
    NAME_z (or `.`, `:`, `-`, blank between, or x_NAME). Two-row: names above a row of X, Y, Z (Vicon, OptiTrack). Case
    does not matter. A unit may stand in brackets (`NAME_x [mm]`) or in a row of its own. Frame numbers that are left
    out become gaps; a time column (seconds, or `[ms]`) gives the rate; in wide forms all other columns become notes.

    Raises:
        BadInput: empty, no such header, frame numbers that run backwards, a cell that is no number.
    """
    sheet = read_sheet(path)
    return _read_long(sheet) if sheet.long else _read_wide(sheet)


def _read_wide(sheet: Sheet) -> RawTake:
    _no_column_twice(sheet)
    found = triples(sheet.columns)
    columns = [i for triple in found.values() for i in triple]
    values = sheet.numbers(columns).reshape(len(sheet.rows), len(found), 3)
    frames, rate, clock = _clock(sheet)
    rest = [i for i, name in enumerate(sheet.columns) if name and i not in {*columns, *clock}]
    return _take(
        labels=list(found),
        positions=spread(values, frames),
        rate=rate,
        mm=sheet.unit(columns),
        notes={sheet.columns[i]: note(sheet, i, frames) for i in rest} if len(sheet.rows) else None,
    )


def _read_long(sheet: Sheet) -> RawTake:
    label_column, frame_column, time_column = sheet.find(LABEL), sheet.find(FRAME), sheet.find(TIME)
    key = frame_column if frame_column is not None else time_column
    axes = [i for axis in "xyz" if (i := sheet.find({axis})) is not None]
    if key is None or label_column is None:
        raise BadInput(f"{sheet.path}: a long table needs a frame or time column beside label, x, y, z")
    keys = sheet.numbers([key])[:, 0]
    if not np.isfinite(keys).all():
        row = sheet.first_row + int(np.argmin(np.isfinite(keys)))
        raise BadInput(f"{sheet.path}: row {row} has no {sheet.columns[key]}; fill it in or drop the row")
    moments, first, which = np.unique(keys, return_index=True, return_inverse=True)
    labels = list(dict.fromkeys(row[label_column] for row in sheet.rows))
    place = {label: i for i, label in enumerate(labels)}
    marker = np.array([place[row[label_column]] for row in sheet.rows], dtype=np.int64)
    _no_row_twice(sheet, keys, which * len(labels) + marker, label_column)
    positions = np.full((len(moments), len(labels), 3), np.nan)
    positions[which, marker] = sheet.numbers(axes)
    times = None if time_column is None else sheet.seconds(time_column)
    frames, rate = _places(sheet, None if frame_column is None else moments, None if times is None else times[first])
    return _take(labels=labels, positions=spread(positions, frames), rate=rate, mm=sheet.unit(axes))


def _take(
    labels: list[str],
    positions: Float[np.ndarray, "frames markers 3"],
    rate: float | None,
    mm: float | None,
    notes: dict[str, np.ndarray] | None = None,
) -> RawTake:
    return RawTake(positions, tuple(labels), rate, mm, notes=notes or None)


def _clock(sheet: Sheet) -> tuple[Int[np.ndarray, " rows"], float | None, set[int]]:
    """Places of the rows, the rate, and the columns that these came from."""
    frame_column, time_column = sheet.find(FRAME), sheet.find(TIME)
    times = None if time_column is None else sheet.seconds(time_column)
    numbers_ = None if frame_column is None else sheet.numbers([frame_column])[:, 0]
    frames, rate = _places(sheet, numbers_, times)
    used = {i for i, values in ((frame_column, numbers_), (time_column, times)) if i is not None and values is not None}
    return frames, rate, used


def _places(
    sheet: Sheet, frame_numbers: np.ndarray | None, times: np.ndarray | None
) -> tuple[Int[np.ndarray, " rows"], float | None]:
    if frame_numbers is not None:
        frames = frames_of_numbers(sheet.path, frame_numbers)
    elif times is not None:
        frames = frames_of_times(sheet.path, times)
    else:
        frames = np.arange(len(sheet.rows))
    rate = None if times is None else rate_of(times, frames)
    stated = sheet.preamble.get("export frame rate") or sheet.preamble.get("rate") or ""
    return frames, rate or known_unit(stated)


def _no_column_twice(sheet: Sheet) -> None:
    count = Counter(part for column in sheet.columns if (part := marker_axis(column)) is not None)
    twice = dict.fromkeys(name for (name, _), times in count.items() if times > 1)
    if twice:
        names = ", ".join(list(twice)[:5])
        raise BadInput(f"{sheet.path}: duplicate marker labels: {names}; give every marker its own name")


def _no_row_twice(sheet: Sheet, keys: np.ndarray, cells: np.ndarray, label_column: int) -> None:
    _, first = np.unique(cells, return_index=True)
    if len(first) == len(cells):
        return
    i = int(np.setdiff1d(np.arange(len(cells)), first)[0])
    raise BadInput(
        f"{sheet.path}: duplicate marker labels: {sheet.rows[i][label_column]} comes twice in frame {keys[i]:g}; "
        "give every marker its own name"
    )
