"""A user's correspondences in the image of one scan, for its flow to keep to."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from scipy.ndimage import distance_transform_edt

from ..flow import FlowConstraints, curve_constraints
from .constraints import PairConstraint
from .layout import SHOWN, sampled

HOLD_MM = 1.5
"""What is said of a point holds this far round it."""


@runtime_checkable
class LaidOutScan(Protocol):
    """A scan in the layout."""

    def pixels(self, points: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "k 2"]:
        """Where points of the scan (mm) are laid out."""
        ...

    def transported(self, points: Float[np.ndarray, "k 3"], uv: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "k 2"]:
        """Where its points come to be when its vertices go to `uv` in the image."""
        ...

    @property
    def uv(self) -> Float[np.ndarray, "n 2"]:
        """Where its vertices are now, pixels."""
        ...


def falloff_round(points: Float[np.ndarray, "k 2"], shape: tuple[int, int], sigma: float) -> Float[np.ndarray, "h w"]:
    """1 at image points, falling off over `sigma` pixels."""
    away = np.ones(shape, bool)
    x, y = np.clip(np.round(points).astype(int), 0, [shape[1] - 1, shape[0] - 1]).T
    away[y, x] = False
    return np.exp(-0.5 * (np.asarray(distance_transform_edt(away)) / sigma) ** 2)


def constraints_in_region(held: FlowConstraints | None, mask: Float[np.ndarray, "h w"]) -> FlowConstraints | None:
    """Those constraints that start in a region."""
    if held is None:
        return None
    inside = sampled(mask, held.source)[:, 0] > SHOWN
    if not inside.any():
        return None
    across = None if held.across is None else held.across[inside]
    return FlowConstraints(held.source[inside], held.target[inside], across)


def constraints_on(
    scans: Sequence[LaidOutScan], i: int, constraints: Sequence[PairConstraint], pixel_mm: float
) -> FlowConstraints | None:
    """What is known of scan i: where in its image the vertices under the other scan's points are, and belong."""
    found: FlowConstraints | None = None
    radius = HOLD_MM / pixel_mm
    for constraint in constraints:
        if i not in constraint.scans:
            continue
        me = constraint.scans.index(i)
        other = scans[constraint.scans[1 - me]]
        parts = []
        if len(constraint.points[0]):
            source = other.transported(constraint.points[1 - me], scans[i].uv)
            parts.append(FlowConstraints(source, scans[i].pixels(constraint.points[me])))
        for curve in constraint.curves:
            source = other.transported(_dense(curve[1 - me]), scans[i].uv)
            parts.append(curve_constraints(source, scans[i].pixels(_dense(curve[me])), spacing=2.0))
        for part in parts:
            part = _spread(part, radius)
            found = part if found is None else found + part
    return found


def _spread(held: FlowConstraints, radius: float) -> FlowConstraints:
    """The same displacements on a disc round each point, so that smoothing does not take them away."""
    grid = np.arange(-np.ceil(radius), np.ceil(radius) + 1)
    around = np.stack(np.meshgrid(grid, grid), -1).reshape(-1, 2)
    around = around[np.linalg.norm(around, axis=1) <= radius]
    source, target = ((x[:, None] + around).reshape(-1, 2) for x in (held.source, held.target))
    across = np.zeros_like(held.source) if held.across is None else held.across
    return FlowConstraints(source, target, np.repeat(across, len(around), axis=0))


def _dense(line: Float[np.ndarray, "p 3"], spacing: float = 1.0) -> Float[np.ndarray, "q 3"]:
    """A polyline with points every `spacing` mm."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0, length[-1], max(2, 1 + int(np.ceil(length[-1] / spacing))))
    return np.stack([np.interp(at, length, line[:, d]) for d in range(3)], 1)
