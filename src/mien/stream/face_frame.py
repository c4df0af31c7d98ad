"""A performance as what is sent of it: 52 ARKit weights, the head's turn, the eyes' angles."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..io.live_link_table import HEAD, NAMES
from ..io.livelink import live_link_rows, rotations_of
from ..rig import Performance


@dataclass(frozen=True)
class FaceFrame:
    """One frame, as every protocol takes it."""

    number: int
    """Frames since the beginning, at `rate`."""
    rate: float
    row: Float[np.ndarray, " values"]
    """Weights and angles (radians) in Live Link Face's order."""
    rotation: Float[np.ndarray, "3 3"]
    """Of the head: face space -> +Y up, as `row` has it."""

    @property
    def weights(self) -> dict[str, float]:
        """By ARKit name."""
        return dict(zip(NAMES, self.row[: len(NAMES)].tolist(), strict=True))


def face_frames(performance: Performance, centre: bool | None = None) -> list[FaceFrame]:
    """All frames of a performance; `centre` as in `write_live_link`.

    Raises:
        BadInput: the rig has no ARKit shape.
    """
    rows = live_link_rows(performance, centre)
    rotations = rotations_of(rows[:, len(NAMES) : len(NAMES) + len(HEAD)])
    return [FaceFrame(t, performance.rate, rows[t], rotations[t]) for t in range(len(performance))]


def sampled(frames: list[FaceFrame], fps: float | None, loop: bool) -> Iterator[FaceFrame]:
    """The frames at another rate (the nearest of each time), over and over with `loop`."""
    rate = fps or frames[0].rate
    count = max(1, round(len(frames) * rate / frames[0].rate))
    number = 0
    while number < count or loop:
        at = min(round(number % count * frames[0].rate / rate), len(frames) - 1)
        frame = frames[at]
        yield FaceFrame(number, rate, frame.row, frame.rotation)
        number += 1
