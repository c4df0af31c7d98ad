"""How far markers are from where the others say: what a solve is worth where no marker sits."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..clip import visible
from ..takes.frame_solve import SolveConfig, solve_frames
from ..takes.marker_model import MarkerModel
from ..transforms import Transform
from .between_markers import BetweenConfig, MotionCovariance, carry_share

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
    doubtful_share: float = 0.6
    """Markers that are told worse than to this share of their motion are a warning; staged takes come to 0.3 to 0.8."""


@dataclass(frozen=True)
class LeftOutError:
    """What was found; NaN where nothing was tried."""

    left_out_mm: float
    """Mean distance of markers from where a solve without them puts them."""
    left_out_share: float
    """... as a share of their mean distance from their places on the neutral face."""
    carry_share: float = 0.0
    """Share with which motion carried from the markers shown is mixed with the shapes', by what either is off."""

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
    covariance: MotionCovariance | None = None,
    between: BetweenConfig = BetweenConfig(),
) -> LeftOutError:
    """How far markers are from where a solve without them puts them: cross-validation over markers.

    Args:
        model: the markers on a rig that was not bent to them.
        positions: lab frame, mm; NaN where not seen.
        T_lab_face: poses to start from.
        covariance: tells hidden markers by the shown ones' motion too, mixed with what shapes say.
    """
    frames = np.unique(np.linspace(0, len(positions) - 1, config.frames).astype(int))
    alone = replace(solve, smoothness=0.0, rounds=config.rounds)
    group = folds(model.neutral, config.folds)
    found = []
    for fold in range(config.folds if config.frames else 0):
        shown = group != fold
        if (visible(positions[frames][:, shown]).sum(axis=1) >= solve.fewest).any():
            found.append(_tell_hidden(model, positions[frames], T_lab_face[frames], shown, metric, alone, covariance))
    if not found or not any(np.isfinite(off).any() for off, _, _ in found):
        return LeftOutError(np.nan, np.nan)
    off, off_carried, moved = (np.concatenate([one[i] for one in found]) for i in range(3))
    share = 0.0 if covariance is None else carry_share(_mean(off), _mean(off_carried), between)
    error = _mean((1 - share) * off + share * off_carried)
    return LeftOutError(error, error / max(_mean(moved), LEAST_MOTION_MM), share)


def _tell_hidden(
    model: MarkerModel, X: np.ndarray, T: Transform, shown: np.ndarray, metric, solve: SolveConfig, covariance
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How far hidden markers are from where shapes, and where carried motion, put them, and from rest: (k, 3) each."""
    few = MarkerModel(model.neutral[shown], model.shapes[:, shown])
    hidden = MarkerModel(model.neutral[~shown], model.shapes[:, ~shown])
    solved = solve_frames(few, X[:, shown], T, RATE, metric, solve)
    seen = solved.T_lab_face[solved.tracked].inverse().apply(X[solved.tracked])
    weights = solved.weights[solved.tracked]
    there = seen[:, ~shown]
    off, moved = there - hidden.points(weights), there - hidden.neutral
    off_carried = off
    if covariance is not None:
        carry = covariance.carry(np.flatnonzero(shown), np.flatnonzero(~shown))
        motion = np.where(np.isfinite(seen[:, shown]), seen[:, shown], few.points(weights)) - few.neutral
        off_carried = moved - np.einsum("hac,tc->tha", carry, motion.reshape(len(motion), -1), optimize=True)
    return off.reshape(-1, 3), off_carried.reshape(-1, 3), moved.reshape(-1, 3)


def _mean(vectors: np.ndarray) -> float:
    """Mean length of those that are known, mm."""
    return float(np.nanmean(np.linalg.norm(vectors, axis=1)))


def folds(places: Float[np.ndarray, "markers 3"], count: int) -> np.ndarray:
    """A group for every marker, 0..count-1, each spread over the face: neighbours in height take turns."""
    group = np.empty(len(places), dtype=np.int64)
    group[np.argsort(places[:, 1], kind="stable")] = np.arange(len(places)) % count
    return group
