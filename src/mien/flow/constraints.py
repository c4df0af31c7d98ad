"""Known correspondences that the flow is held to: what a user draws on two images."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mien.errors import BadInput

from .warp import smooth, splat

SLACK = 0.05
"""How strongly a curve's points are held along the curve, relative to across it."""


@dataclass(frozen=True)
class FlowConstraints:
    """Points of the source image and where they are in the target, pixels (x, y).

    Points on a curve may slide: they are held firmly across it and slackly along it.
    """

    source: Float[np.ndarray, "k 2"]
    target: Float[np.ndarray, "l 2"]
    """As many."""
    across: Float[np.ndarray, "k 2"] | None = None
    """Unit direction in which a point is held firmly, 0 where it is held in all; None: all points in all."""

    def __post_init__(self):
        if self.source.shape != self.target.shape:
            raise BadInput(
                f"flow constraints: {len(self.source)} source points but {len(self.target)} target points; give pairs"
            )
        if not (np.isfinite(self.source).all() and np.isfinite(self.target).all()):
            raise BadInput("flow constraints: a point is not finite; leave it out")

    @property
    def stiffness(self) -> Float[np.ndarray, "k 2 2"]:
        """Quadratic form of every point's miss, relative: the identity for one held in all directions."""
        full = np.broadcast_to(np.eye(2), (len(self.source), 2, 2))
        if self.across is None:
            return full
        along = 1 - (self.across**2).sum(1)[:, None, None]
        held = SLACK * np.eye(2) + (1 - SLACK) * self.across[:, :, None] * self.across[:, None, :]
        return np.where(along > 0.5, full, held)

    def __add__(self, other: "FlowConstraints") -> "FlowConstraints":
        """The constraints of both."""
        both = [c.across if c.across is not None else np.zeros_like(c.source) for c in (self, other)]
        return FlowConstraints(
            np.concatenate([self.source, other.source]),
            np.concatenate([self.target, other.target]),
            np.concatenate(both),
        )

    def at_scale(
        self, scale: tuple[float, float], shape: tuple[int, ...]
    ) -> tuple[Float[np.ndarray, "k 2"], Float[np.ndarray, "k 2"]]:
        """Places and displacements in the pixels of a level (height, width), places moved inside it."""
        places = (self.source + 0.5) * scale - 0.5
        return np.clip(places, 0, [shape[1] - 1, shape[0] - 1]), (self.target - self.source) * scale

    def start(self, flow: Float[np.ndarray, "h w 2"], scale: tuple[float, float], reach: float) -> np.ndarray:
        """`flow` with what the constraints say within about `reach` pixels round them: where a level starts from."""
        places, moves = self.at_scale(scale, flow.shape[:2])
        sigma = max(0.6 * reach * scale[0], 0.5)
        sums = splat(places, np.column_stack([moves, np.ones(len(moves))]), flow.shape[:2])
        sums = smooth(sums.astype(np.float32), sigma, odd=False)
        share = np.minimum(sums[..., 2:] * np.float32(8 * np.pi * sigma**2), 1)
        return (1 - share) * flow + share * sums[..., :2] / np.maximum(sums[..., 2:], np.float32(1e-12))

    def moved(self, offset: tuple[int, int]) -> "FlowConstraints":
        """In a frame whose origin is at `offset` (x, y)."""
        return FlowConstraints(self.source - offset, self.target - offset, self.across)


def curve_constraints(
    source: Float[np.ndarray, "k 2"], target: Float[np.ndarray, "l 2"], spacing: float = 1.0
) -> FlowConstraints:
    """Two polylines that are the same line, from end to end, as point pairs `spacing` pixels apart on the source.

    The pairs are at equal shares of arc length; the two ends are held in all directions, the points between
    firmly across the target curve and slackly along it.

    Raises:
        BadInput: a curve of fewer than two points or of no length.
    """
    length = min(_arc_length(source, "source")[-1], _arc_length(target, "target")[-1])
    if length == 0:
        raise BadInput("flow constraints: a curve has no length; give its two ends at least")
    share = np.linspace(0, 1, max(2, 1 + round(_arc_length(source, "source")[-1] / spacing)))
    ends, goals = _along(source, share), _along(target, share)
    tangent = np.gradient(goals, axis=0)
    across = np.stack([-tangent[:, 1], tangent[:, 0]], 1)
    across = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    across[[0, -1]] = 0
    return FlowConstraints(ends, goals, across)


def _arc_length(line: np.ndarray, name: str) -> np.ndarray:
    if len(line) < 2:
        raise BadInput(f"flow constraints: the {name} curve has {len(line)} points; a curve needs two or more")
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def _along(line: np.ndarray, share: np.ndarray) -> np.ndarray:
    length = _arc_length(line, "")
    return np.stack([np.interp(share * length[-1], length, line[:, d]) for d in range(2)], 1)
