"""The clock of a folder: `timestamps.csv`, as several recorders write it."""

import csv
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..errors import BadInput

_UNITS = (("ns", 1e-9), ("nano", 1e-9), ("us", 1e-6), ("micro", 1e-6), ("ms", 1e-3), ("milli", 1e-3), ("sec", 1.0))
_KEYS = ("frame", "index", "number", "file", "filename", "name", "id")
_LONGEST_FRAME_S = 5.0
"""Frames that seem longer apart than this are stamped in a smaller unit than seconds."""


def read_timestamps(
    path: Path, files: Sequence[Path], numbers: Float[np.ndarray, " frames"]
) -> Float[np.ndarray, " frames"]:
    """Seconds of the frames from the first on. Rows are found by frame number or file name, else by their order.

    A header may name the columns (`frame,seconds`); milliseconds, microseconds and nanoseconds are told by it or by
    their size. `,`, `;`, tab or blanks part them.

    Raises:
        BadInput: no time for a frame, or times that do not grow.
    """
    try:
        header, rows = _rows(path)
        key, value, unit = _columns(header)
        times = np.array([float(row[value].replace(",", ".")) for row in rows])
        keys = None if key is None else [row[key].strip() for row in rows]
        found = times[_places(keys, files, numbers, len(rows))]
    except (KeyError, ValueError, IndexError, TypeError, OverflowError, csv.Error) as error:
        raise BadInput(
            f"{path}: needs columns frame,seconds, a row for each of {len(files)} frames ({error!r})"
        ) from error
    grows = np.diff(found) > 0
    if not (grows.all() and np.isfinite(found).all()):
        after = int(np.argmin(grows)) if len(grows) else 0
        raise BadInput(f"{path}: seconds must grow; they do not after frame {after}")
    return (found - found[:1]) * (stamp_unit(found) if unit is None else unit)


def _rows(path: Path) -> tuple[list[str], list[list[str]]]:
    lines = [line for line in path.read_text("utf-8-sig", "replace").splitlines() if line.strip(" ,;\t")]
    lines = [line for line in lines if not line.lstrip().startswith("#")] or lines
    delimiter = next((d for d in ";\t," if lines and d in lines[0]), " ")
    table = list(csv.reader(lines, delimiter=delimiter, skipinitialspace=True))
    named = bool(table) and not any(cell.strip()[:1].isdigit() for cell in table[0])
    return ([cell.strip().lower() for cell in table[0]] if named else []), table[int(named) :]


def _columns(header: list[str]) -> tuple[int | None, int, float | None]:
    """Column of the frame (None: by order), column of the time, seconds in its unit (None: unknown)."""
    if not header:
        return None, -1, None
    times = [i for i, name in enumerate(header) if any(word in name for word in ("sec", "time", "stamp", "ms", "ns"))]
    keys = [
        i for i, name in enumerate(header) if name in ("frame", "index", "number", "file", "filename", "name", "id")
    ]
    value = times[0] if times else len(header)
    named = header[value] if times else ""
    unit = next((size for word, size in _UNITS if word in named), None)
    return (keys[0] if keys else None), value, unit


def _places(keys: list[str] | None, files: Sequence[Path], numbers: np.ndarray, rows: int) -> list[int]:
    if keys is None:
        if rows != len(files):
            raise ValueError(f"{rows} rows")
        return list(range(rows))
    by_name = {Path(key).stem: i for i, key in enumerate(keys)}
    if all(file.stem in by_name for file in files):
        return [by_name[file.stem] for file in files]
    by_number = {int(float(key)): i for i, key in enumerate(keys)}
    own = [int(found[-1]) if (found := re.findall(r"\d+", file.stem)) else -1 for file in files]
    if all(number in by_number for number in own):
        return [by_number[number] for number in own]
    return [by_number[round(number)] for number in numbers]


def stamp_unit(times: np.ndarray) -> float:
    """Seconds in one unit of growing time stamps, by how far frames are apart."""
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    return next((unit for unit in (1.0, 1e-3, 1e-6) if step * unit <= _LONGEST_FRAME_S), 1e-9)
