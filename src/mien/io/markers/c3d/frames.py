"""Where a C3D file keeps its frames, and the frames themselves."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ....errors import BadInput
from .numbers import floats, words
from .parameters import BLOCK, LARGEST_WORD, C3dHeader, C3dParameters

_POINT_VALUES = 4
"""x, y, z and the residual."""


@dataclass(frozen=True)
class C3dLayout:
    """How the frames lie in the file."""

    start: int
    """Byte of the first frame."""
    points: int
    analog: int
    """Analog values behind the points of every frame."""
    scale: float
    """Length of one integer step; negative: floats."""
    frames: int
    counted: bool = False
    """The number of frames is that for which the file has room; zeros may fill its last block."""

    @property
    def width(self) -> int:
        """Bytes a value."""
        return 4 if self.scale < 0 else 2

    @property
    def frame_bytes(self) -> int:
        """Bytes a frame."""
        return self.width * (_POINT_VALUES * self.points + self.analog)

    @property
    def end(self) -> int:
        """Byte behind the last frame."""
        return self.start + self.frames * self.frame_bytes


def find_layout(path: Path, size: int, header: C3dHeader, parameters: C3dParameters) -> C3dLayout:
    """The layout of which header and parameters speak. Where they contradict each other: the one that fills the file.

    Raises:
        BadInput: the file is too short for every one of them, or two fit and differ.
    """
    stated = list(dict.fromkeys(_stated(size, header, parameters)))
    if not stated:
        raise BadInput(f"{path}: its header leads to no frames; it is damaged or cut off; export it again")
    if stated[0].points == 0:
        return replace(stated[0], frames=0)
    inside = [layout for layout in stated if layout.end <= size]
    if not inside:
        first = stated[0]
        there = _room(first, size)
        raise BadInput(f"{path}: cut off: its header promises {first.frames} frames, {there} are there; copy it again")
    filling = [layout for layout in inside if size - layout.end < BLOCK] or inside
    if len({layout.points for layout in filling}) > 1:
        used = parameters.count("POINT", "USED")
        raise BadInput(
            f"{path}: is damaged: {header.points} points in its header, {used} in POINT:USED; export it again"
        )
    return filling[0]


def read_frames(data: bytes, layout: C3dLayout, processor: int) -> Float[np.ndarray, "frames points 3"]:
    """Positions in the file's unit, NaN where the residual is negative or a coordinate is no number."""
    raw = data[layout.start : layout.end]
    values = floats(raw, processor) if layout.scale < 0 else words(raw, processor).astype(np.float64)
    per_frame = _POINT_VALUES * layout.points
    points = values.reshape(layout.frames, per_frame + layout.analog)[:, :per_frame]
    points = points.reshape(layout.frames, layout.points, _POINT_VALUES)
    if layout.counted:
        points = points[: _without_fill(points, BLOCK // layout.frame_bytes)]
    step = 1.0 if layout.scale < 0 else layout.scale
    seen = (points[:, :, 3] >= 0) & np.isfinite(points[:, :, :3]).all(axis=2)
    return np.where(seen[:, :, None], points[:, :, :3], np.nan) * step


def _without_fill(points: Float[np.ndarray, "frames points 4"], most: int) -> int:
    """Frames without those at the end, `most` at most, that are nothing but zeros."""
    empty = np.asarray(~points[-most:].any(axis=(1, 2))) if most else np.zeros(0, bool)
    filled = int(np.argmin(empty[::-1])) if not empty.all() else len(empty)
    return len(points) - filled


def _stated(size: int, header: C3dHeader, parameters: C3dParameters) -> Iterator[C3dLayout]:
    """Every layout that header and parameters name together, the likeliest first."""
    points = _distinct(parameters.count("POINT", "USED") or None, header.points or None) or [0]
    scales = _distinct(parameters.number("POINT", "SCALE") or None, header.scale or None) or [-1.0]
    data_start = parameters.count("POINT", "DATA_START")
    starts = [start for start in _distinct(_byte(data_start), _byte(header.data_block)) if BLOCK <= start <= size]
    starts = starts or [min(parameters.end, size)]
    analogs = _distinct(header.analog, _analog(header, parameters))
    for start, count, scale, analog in product(starts, points, scales, analogs):
        layout = C3dLayout(start, count, analog, scale, 0)
        counts = _frame_counts(layout, size, header, parameters)
        yield from (replace(layout, frames=frames) for frames in counts)
        if not counts:
            yield replace(layout, frames=_room(layout, size), counted=True)


def _frame_counts(layout: C3dLayout, size: int, header: C3dHeader, parameters: C3dParameters) -> list[int]:
    """Numbers of frames that the file states; from 65,535 on the header has no room, and the file's length tells."""
    there = _room(layout, size)
    short = _distinct(header.frames, parameters.count("POINT", "FRAMES"))
    short = [count for count in short if 0 < count < LARGEST_WORD]
    wrapped = [count + (there - count) // (LARGEST_WORD + 1) * (LARGEST_WORD + 1) for count in short if count < there]
    long = _distinct(_trial_frames(parameters), parameters.count("POINT", "LONG_FRAMES"))
    long = [count for count in long if count >= 1]
    return _distinct(*long, *short, *wrapped)


def _room(layout: C3dLayout, size: int) -> int:
    """Whole frames for which the file has room."""
    return max(size - layout.start, 0) // max(layout.frame_bytes, 1)


def _trial_frames(parameters: C3dParameters) -> int | None:
    """TRIAL:ACTUAL_START_FIELD to ACTUAL_END_FIELD: two 16-bit words each, the low one first."""
    ends = []
    for name in ("ACTUAL_START_FIELD", "ACTUAL_END_FIELD"):
        values = parameters.groups.get("TRIAL", {}).get(name, [])
        if len(values) == 0 or isinstance(values, list) or not np.isfinite(values).all():
            return None
        low, *high = values
        whole = values.dtype.kind == "i"
        ends.append(int(low) % (LARGEST_WORD + 1) + (int(high[0]) << 16 if high else 0) if whole else int(low))
    return ends[1] - ends[0] + 1


def _analog(header: C3dHeader, parameters: C3dParameters) -> int | None:
    """Analog values a frame as the ANALOG group has it: channels times samples a frame."""
    channels = parameters.count("ANALOG", "USED")
    rate = parameters.number("ANALOG", "RATE")
    points_rate = parameters.number("POINT", "RATE") or header.rate
    if channels is None or channels > LARGEST_WORD:
        return None
    samples = round(rate / points_rate) if rate and points_rate > 0 and 1 <= rate / points_rate < LARGEST_WORD else 1
    return channels * samples


def _byte(block: int | None) -> int | None:
    return (block - 1) * BLOCK if block else None


def _distinct(*values):
    """Those that are not None, each once, in order."""
    return [value for value in dict.fromkeys(values) if value is not None]
