"""How far markers are from where the others say: what a solve is worth where no marker sits."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..clip import visible
from ..takes.frame_solve import SolveConfig, solve_frames
from ..takes.marker_model import MarkerModel
from ..transforms import Transform

RATE = 30.0
"""Frames a second that the chosen frames are said to have; without smoothness nothing depends on it."""

LEAST_MOTION_MM = 0.1
"""A share of less motion than markers jitter says nothing."""


@dataclass(frozen=True)
class LeftOutConfig:
    """How markers are left out by turns."""

    folds: int = 4
    """Groups of markers; each is left out once."""
    frames: int = 60
    """Frames of the take that it is tried on; 0 leaves it undone."""
    rounds: int = 2
    """Gauss-Newton rounds of each solve."""
    doubtful_share: float = 0.7
    """Markers that are told worse than to this share of their motion are a warning; staged takes come to 0.3 to 0.8."""


@dataclass(frozen=True)
class LeftOutError:
    """What was found; NaN where nothing was tried."""

    left_out_mm: float
    """Mean distance of markers from where a solve without them puts them."""
    left_out_share: float
    """... as a share of their mean distance from their places on the neutral face."""

    def __str__(self) -> str:
        if not np.isfinite(self.left_out_mm):
            return ""
        return f"left-out markers told to {self.left_out_mm:.2f} mm ({self.left_out_share:.0%} of their motion)"


def left_out_doubt(found: LeftOutError, config: LeftOutConfig = LeftOutConfig()) -> tuple[str, ...]:
    """A line where the face's shapes say little of the markers."""
    if not found.left_out_share > config.doubtful_share:
        return ()
    return (
        f"markers left out by turns are told badly ({found.left_out_share:.0%} of their motion is missed): between the "
        "markers the face is little better than frozen",
    )


def leave_markers_out(
    model: MarkerModel,
    positions: Float[np.ndarray, "frames markers 3"],
    T_lab_face: Transform,
    metric: Float[np.ndarray, "3 3"] | None = None,
    solve: SolveConfig = SolveConfig(),
    config: LeftOutConfig = LeftOutConfig(),
) -> LeftOutError:
    """How far markers are from where a solve without them puts them: cross-validation over markers.

    Args:
        model: the markers on a rig that was not bent to them.
        positions: lab frame, mm; NaN where not seen.
        T_lab_face: poses to start from.
    """
    frames = np.unique(np.linspace(0, len(positions) - 1, config.frames).astype(int))
    alone = replace(solve, smoothness=0.0, rounds=config.rounds)
    group = folds(model.neutral, config.folds)
    off, moved = [], []
    for fold in range(config.folds if config.frames else 0):
        shown = group != fold
        X, T = positions[frames], T_lab_face[frames]
        if (visible(X[:, shown]).sum(axis=1) >= solve.fewest).sum() == 0:
            continue
        few = MarkerModel(model.neutral[shown], model.shapes[:, shown])
        solved = solve_frames(few, X[:, shown], T, RATE, metric, alone)
        here, there = solved.T_lab_face[solved.tracked], X[solved.tracked][:, ~shown]
        hidden = MarkerModel(model.neutral[~shown], model.shapes[:, ~shown])
        off.append(_distances(there, here.apply(hidden.points(solved.weights[solved.tracked]))))
        moved.append(_distances(there, here.apply(np.broadcast_to(hidden.neutral, there.shape))))
    if not off or not np.isfinite(np.concatenate(off)).any():
        return LeftOutError(np.nan, np.nan)
    error = float(np.nanmean(np.concatenate(off)))
    return LeftOutError(error, error / max(float(np.nanmean(np.concatenate(moved))), LEAST_MOTION_MM))


def _distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.linalg.norm(a - b, axis=2).ravel()


def folds(places: Float[np.ndarray, "markers 3"], count: int) -> np.ndarray:
    """A group for every marker, 0..count-1, each spread over the face: neighbours in height take turns."""
    group = np.empty(len(places), dtype=np.int64)
    group[np.argsort(places[:, 1], kind="stable")] = np.arange(len(places)) % count
    return group
