"""Further channels beside a take (strain gauges and the like): a table with a time column and any others."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..text.decode_text import decode_text
from .markers.tables.delimited_table import cells_to_numbers, commonest_delimiter, pad

_SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "ns": 1e-9}
_TIME = re.compile(r"(?:time|times|timestamp|t)?[\s_(\[]*(s|sec|seconds|ms|milliseconds|us|ns)?[)\]]*")
"""What a time column is called: time, t, seconds, time_ms, time (s), ..."""


@dataclass(frozen=True)
class GaugeTable:
    """Channels by time."""

    name: str
    """What messages call it."""
    times: Float[np.ndarray, " r"]
    """Seconds from the take's first frame, increasing."""
    channels: tuple[str, ...]
    values: Float[np.ndarray, "r channels"]
    """In whatever unit; NaN where a cell is empty."""

    def only(self, channels: tuple[str, ...]) -> "GaugeTable":
        """Some of the channels, in this order."""
        at = [self.channels.index(channel) for channel in channels]
        return GaugeTable(self.name, self.times, channels, self.values[:, at])


def read_gauges(path: Path) -> GaugeTable:
    """Read a table: a header, a time column (seconds, or as its name says: time_ms), any further columns.

    Raises:
        BadInput: no time column, no channel, a name twice, a cell that is no number, times that do not increase.
    """
    lines = [line for line in decode_text(path).splitlines() if line.strip()]
    delimiter = commonest_delimiter(lines[0] if lines else "")
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
    header, body = (rows[0], rows[1:]) if rows else ([], [])
    found = [_TIME.fullmatch(name.lower()) if name else None for name in header]
    at = next((i for i, match in enumerate(found) if match), None)
    if at is None:
        raise BadInput(f"{path}: has no time column; write a header such as time,brow_left,brow_right (seconds)")
    others = [i for i, name in enumerate(header) if i != at and name]
    names = tuple(header[i] for i in others)
    if not names:
        raise BadInput(f"{path}: has times but no further column; write one column a gauge")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise BadInput(f"{path}: column {twice[0]!r} stands there twice; give each gauge its own name")
    cells = [[row[i] for i in (at, *others)] for row in (pad(row, len(header)) for row in body)]
    numbers = cells_to_numbers(path, cells, list(range(2, len(cells) + 2)))
    match = found[at]
    unit = (match.group(1) if match else None) or ""
    times = numbers[:, 0] * _SECONDS[unit]
    if len(times) < 2 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise BadInput(
            f"{path}: its times must be two at least, numbers that increase; sort the rows and drop repeated ones"
        )
    return GaugeTable(str(path), times, names, numbers[:, 1:])
