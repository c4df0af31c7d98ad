"""Frame numbers and times of a table's rows -> places of the rows in the take, and its rate."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from ...errors import BadInput


def frames_of_numbers(path: Path, values: Float[np.ndarray, " rows"]) -> Int[np.ndarray, " rows"]:
    """Frame numbers as stored -> places counted from 0; a step other than one becomes one; numbers left out stay free.

    Without usable numbers (empty cells, fractions): 0, 1, 2, ...

    Raises:
        BadInput: they do not increase, or leave out nearly everything.
    """
    if len(values) < 2 or not (np.isfinite(values).all() and (values == np.round(values)).all()):
        return np.arange(len(values))
    _increasing(path, values, "frame numbers")
    steps = np.diff(values.astype(np.int64))
    places = np.concatenate([[0], np.cumsum(steps // np.gcd.reduce(steps))])
    if places[-1] > 50 * len(values) + 1000:
        raise BadInput(
            f"{path}: {len(values)} frames are numbered {values[0]:g} to {values[-1]:g}; renumber or split the take"
        )
    return places


def frames_of_times(path: Path, times: Float[np.ndarray, " rows"]) -> Int[np.ndarray, " rows"]:
    """Times in seconds -> places counted from 0, those of dropped frames left free.

    Raises:
        BadInput: they do not increase.
    """
    if len(times) < 2 or not np.isfinite(times).all():
        return np.arange(len(times))
    _increasing(path, times, "times")
    places = np.round((times - times[0]) / np.median(np.diff(times))).astype(np.int64)
    usable = (np.diff(places) > 0).all() and places[-1] <= 50 * len(times) + 1000
    return places if usable else np.arange(len(times))


def rate_of(times: Float[np.ndarray, " rows"], frames: Int[np.ndarray, " rows"]) -> float | None:
    """Frames a second from first to last finite time, or the whole number beside it if that fits the (rounded) times
    as well. None without times."""
    known = np.flatnonzero(np.isfinite(times))
    if len(known) < 2 or times[known[-1]] <= times[known[0]]:
        return None
    t = times[known] - times[known[0]]
    f = frames[known] - frames[known[0]]
    rate = float(f[-1] / t[-1])
    whole = float(max(1, round(rate)))
    misfit, misfit_whole = (np.abs(t - f / r).max() for r in (rate, whole))
    return whole if misfit_whole <= 1.5 * misfit + 1e-9 else rate


def spread(
    rows: Float[np.ndarray, "rows markers 3"], frames: Int[np.ndarray, " rows"]
) -> Float[np.ndarray, "frames markers 3"]:
    """Rows at their places; NaN in frames that have none."""
    if len(rows) == 0:
        return rows
    out = np.full((frames[-1] + 1, *rows.shape[1:]), np.nan)
    out[frames] = rows
    return out


def _increasing(path: Path, values: np.ndarray, what: str) -> None:
    if (np.diff(values) <= 0).any():
        i = int(np.argmax(np.diff(values) <= 0))
        raise BadInput(
            f"{path}: {what} must increase, but {values[i]:g} is followed by {values[i + 1]:g}; "
            "sort the rows or split the take"
        )
