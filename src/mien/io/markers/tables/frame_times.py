"""Frame numbers and times of a table's rows -> places of the rows in the take, and its rate."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from ....errors import BadInput
from .delimited_table import DelimitedTable, positive_number

_RATE_KEYS = (
    "export frame rate",
    "capture frame rate",
    "frame rate",
    "framerate",
    "fps",
    "rate",
    "frequency",
    "datarate",
    "data rate",
    "sample rate",
    "sampling rate",
    "frequency (hz)",
)
"""What programs call the rate ahead of the header; Motive's export may leave frames out, so its rate comes first."""

_MOST_GAPS = 50
"""Frames left out for each one that is there; beyond, the numbers are no frame numbers."""
_SLACK = 1000
"""Frames that even a short table may leave out."""
_LARGEST_NUMBER = 2.0**53
"""Whole numbers are exact in float64 up to here."""
_SLOWEST, _FASTEST = 1.0, 5000.0
"""Frames a second of a capture; times that give less are taken for milli-, micro- or nanoseconds."""
_SMALLER_UNITS = {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
_SAME_RATE = 0.01
"""A stated rate within 1 % of that of the (rounded) times is the exact one."""


def place_rows(
    table: DelimitedTable, numbers: Float[np.ndarray, " rows"] | None, times: Float[np.ndarray, " rows"] | None
) -> tuple[Int[np.ndarray, " rows"], float | None, list[str]]:
    """(places of the rows, rate, lines) from frame numbers, or else times, or else the order; rate None: not said."""
    if numbers is not None:
        frames = frames_of_numbers(table.path, numbers)
    elif times is not None:
        frames = frames_of_times(table.path, times)
    else:
        frames = np.arange(len(table.rows))
    stated = next((rate for key in _RATE_KEYS if (rate := positive_number(table.preamble.get(key, "")))), None)
    timed, lines = (None, []) if times is None else _rate_in_seconds(table, times, frames)
    if stated and (timed is None or abs(timed - stated) <= _SAME_RATE * stated):
        return frames, stated, lines
    return frames, timed, lines


def frames_of_numbers(path: Path, values: Float[np.ndarray, " rows"]) -> Int[np.ndarray, " rows"]:
    """Frame numbers as stored -> places counted from 0; a step other than one becomes one; numbers left out stay free.

    Without usable numbers (empty cells, fractions): 0, 1, 2, ...

    Raises:
        BadInput: they do not increase, or leave out nearly everything.
    """
    if len(values) < 2 or not (np.isfinite(values).all() and (values == np.round(values)).all()):
        return np.arange(len(values))
    _increasing(path, values, "frame numbers")
    renumber = f"{path}: {len(values)} frames are numbered {values[0]:g} to {values[-1]:g}; renumber or split the take"
    if np.abs(values).max() > _LARGEST_NUMBER:
        raise BadInput(renumber)
    steps = np.diff(values.astype(np.int64))
    places = np.concatenate([[0], np.cumsum(steps // np.gcd.reduce(steps))])
    if places[-1] > _MOST_GAPS * len(values) + _SLACK:
        raise BadInput(renumber)
    return places


def frames_of_times(path: Path, times: Float[np.ndarray, " rows"]) -> Int[np.ndarray, " rows"]:
    """Times in seconds -> places counted from 0, those of dropped frames left free.

    Raises:
        BadInput: they do not increase.
    """
    if len(times) < 2 or not np.isfinite(times).all():
        return np.arange(len(times))
    _increasing(path, times, "times")
    in_steps = (times - times[0]) / np.median(np.diff(times))
    if not in_steps[-1] <= _MOST_GAPS * len(times) + _SLACK:
        return np.arange(len(times))
    places = np.round(in_steps).astype(np.int64)
    return places if (np.diff(places) > 0).all() else np.arange(len(times))


def rate_of(times: Float[np.ndarray, " rows"], frames: Int[np.ndarray, " rows"]) -> float | None:
    """Frames a second from first to last finite time, or the whole number beside it if that fits the (rounded) times
    as well. None without times."""
    known = np.flatnonzero(np.isfinite(times))
    if len(known) < 2 or times[known[-1]] <= times[known[0]]:
        return None
    t = times[known] - times[known[0]]
    f = frames[known] - frames[known[0]]
    if not np.isfinite(t).all() or not 1 / _LARGEST_NUMBER < f[-1] / t[-1] < _LARGEST_NUMBER:
        return None
    rate = float(f[-1] / t[-1])
    whole = float(max(1, round(rate)))
    misfit, misfit_whole = (np.abs(t - f / r).max() for r in (rate, whole))
    return whole if misfit_whole <= 1.5 * misfit + 1e-9 else rate


def at_frames(
    rows: Float[np.ndarray, "rows markers 3"], frames: Int[np.ndarray, " rows"]
) -> Float[np.ndarray, "frames markers 3"]:
    """Rows at their places; NaN in frames that have none."""
    if len(rows) == 0:
        return rows
    out = np.full((frames[-1] + 1, *rows.shape[1:]), np.nan)
    out[frames] = rows
    return out


def repeated_rows(table: DelimitedTable) -> tuple[DelimitedTable, list[str]]:
    """Without rows that repeat the one before, cell for cell, and a line."""
    keep = [i for i, row in enumerate(table.rows) if i == 0 or row != table.rows[i - 1]]
    copies = len(table.rows) - len(keep)
    if not copies:
        return table, []
    return table.with_rows(keep), [f"{table.path}: {copies} rows repeat the one before and were left out"]


def _rate_in_seconds(
    table: DelimitedTable, times: Float[np.ndarray, " rows"], frames: Int[np.ndarray, " rows"]
) -> tuple[float | None, list[str]]:
    """(rate, lines): times that make no capture's rate in seconds are read in a smaller unit that does."""
    rate = rate_of(times, frames)
    if rate is None or rate >= _SLOWEST:
        return rate, []
    for name, seconds in _SMALLER_UNITS.items():
        finer = rate_of(times * seconds, frames)
        if finer is not None and _SLOWEST < finer <= _FASTEST:
            return finer, [f"{table.path}: its times are read as {name}: {finer:g} frames/s"]
    return rate, []


def _increasing(path: Path, values: np.ndarray, what: str) -> None:
    if (np.diff(values) <= 0).any():
        i = int(np.argmax(np.diff(values) <= 0))
        raise BadInput(
            f"{path}: {what} must increase, but {values[i]:g} is followed by {values[i + 1]:g}; "
            "sort the rows or split the take"
        )
