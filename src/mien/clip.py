"""A marker take."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from .one_line import count, one_line


def visible(positions: Float[np.ndarray, "frames markers 3"]) -> Bool[np.ndarray, "frames markers"]:
    """Where a marker was seen: all three coordinates are finite."""
    return np.asarray(np.isfinite(positions).all(axis=2))


@dataclass(frozen=True)
class Markers:
    """Labelled marker trajectories in the lab's frame."""

    positions: Float[np.ndarray, "frames markers 3"]
    """Millimetres; NaN where a marker was not seen."""
    labels: tuple[str, ...]
    """One name a marker, all different."""
    rate: float
    """Frames a second."""
    notes: dict[str, np.ndarray] | None = None
    """Further columns of the file, one value a frame (a stimulus name, a time code)."""

    def __repr__(self) -> str:
        seconds = len(self.positions) / self.rate
        gaps = 1 - self.seen.mean() if self.positions.size else 0.0
        frames = count(len(self.positions), "frames")
        taken = f"{frames} at {self.rate:g} a second ({seconds:.1f} s)"
        return one_line(self, count(len(self.labels), "markers"), taken, f"{gaps:.1%} unseen")

    def __post_init__(self):
        if len(self.labels) != self.positions.shape[1]:
            raise ValueError(f"labels: expected {self.positions.shape[1]}, one a marker, got {len(self.labels)}")

    @property
    def seen(self) -> Bool[np.ndarray, "frames markers"]:
        """Where there is a position."""
        return visible(self.positions)

    def only(self, which: Int[np.ndarray, " k"]) -> "Markers":
        """Some of the markers, by number."""
        return replace(self, positions=self.positions[:, which], labels=tuple(self.labels[i] for i in which.tolist()))

    def with_positions(self, positions: Float[np.ndarray, "frames markers 3"]) -> "Markers":
        """The same markers, moved."""
        return replace(self, positions=positions)
