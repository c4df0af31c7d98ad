"""How far markers are from where the others say: what a solve is worth where no marker sits."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..clip import visible
from ..takes.frame_solve import SolveConfig, solve_frames
from ..takes.marker_model import MarkerModel
from ..takes.motion_covariance import MotionCovariance
from ..transforms import Transform
from .between_markers import BetweenConfig, carry_share

RATE = 30.0
"""Frames a second that the chosen frames are said to have; without smoothness nothing depends on it."""

LEAST_MOTION_MM = 0.1
"""A share of less motion than markers jitter says nothing."""

NORMAL_MEDIAN = 0.6745
"""Median of a normal variate's size, in its deviations."""


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
    """Markers told worse than to this share of a frozen face's error are a warning; takes come to 0.3 to 1.3."""
    taken_away: float = 2.0
    """Share of a frozen face's error that a neutral leaves open for each share of motion that must be taken away from
    it; half and twice as much know the order of staged takes less well; 0: none."""
    doubtful_expected: float = 0.7
    """An expected error worse than this share of a frozen face's is a warning too."""


@dataclass(frozen=True)
class LeftOutError:
    """What was found; NaN where nothing was tried."""

    left_out_mm: float
    """rms distance of markers from where a solve without them puts them, without their own jitter."""
    left_out_share: float
    """... as a share of their rms distance from their mean places in the head's frame: 1 is a frozen face's."""
    carry_share: float = 0.0
    """Share with which motion carried from the markers shown is mixed with the shapes', by what either is off."""
    marker_mm: Float[np.ndarray, "frames markers"] | None = None
    """Each marker's distance in the frames tried, with its jitter; NaN where it was not seen."""
    marker_motion_mm: Float[np.ndarray, "frames markers"] | None = None
    """... and from its mean place."""
    jitter_mm: float = 0.0
    """rms distance of a sample from where the marker was, as neighbouring frames tell."""
    neutral_share: float = np.nan
    """`left_out_mm` as a share of how far the markers are from their places on the neutral face."""
    open_share: float = 0.0
    """What the neutral leaves open (`neutral_leaves_open`), of which markers left out say nothing."""

    @property
    def motion_mm(self) -> float:
        """How far markers move, rms without jitter; 0 where nothing was tried."""
        return 0.0 if self.marker_motion_mm is None else without_jitter(self.marker_motion_mm, self.jitter_mm)

    @property
    def expected_share(self) -> float:
        """Expected error of expressions as a share of a frozen face's: what markers miss, and what the neutral does."""
        return float(np.hypot(self.left_out_share, self.open_share))

    def __str__(self) -> str:
        if not np.isfinite(self.left_out_mm):
            return ""
        return (
            f"left-out markers told to {self.left_out_mm:.2f} mm ({self.left_out_share:.0%} of a frozen face's error, "
            f"{self.expected_share:.0%} with what the neutral leaves open)"
        )


def neutral_leaves_open(added: float, config: LeftOutConfig = LeftOutConfig()) -> float:
    """How far expressions may be off by the neutral, a frozen face's error being 1.

    Args:
        added: `Neutral.added`, of squared motion; what is not added must be taken away from the neutral.
    """
    return config.taken_away * float(np.sqrt(max(1 - added, 0.0)))


def left_out_doubt(found: LeftOutError, config: LeftOutConfig = LeftOutConfig()) -> tuple[str, ...]:
    """A line where the face's shapes say little of the markers, or the neutral may be none."""
    if found.left_out_share > config.doubtful_share:
        return (
            f"markers left out by turns are told badly ({found.left_out_share:.0%} of a frozen face's error): between "
            "the markers the face is little better than frozen",
        )
    if found.expected_share > config.doubtful_expected:
        return (
            f"the neutral may be none, and every expression off by what it shows ({found.expected_share:.0%} of a "
            "frozen face's error): name a frame at rest with --neutral",
        )
    return ()


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
    off, off_carried, moved = np.full((3, len(frames), *model.neutral.shape), np.nan)
    for fold in range(config.folds if config.frames else 0):
        shown = group != fold
        if (visible(positions[frames][:, shown]).sum(axis=1) >= solve.fewest).any():
            told = _tell_hidden(model, positions[frames], T_lab_face[frames], shown, metric, alone, covariance)
            off[:, ~shown], off_carried[:, ~shown], moved[:, ~shown] = told
    if not np.isfinite(off).any():
        return LeftOutError(np.nan, np.nan)
    share = 0.0 if covariance is None else carry_share(_mean(off), _mean(off_carried), between)
    distance = np.linalg.norm((1 - share) * off + share * off_carried, axis=2)
    motion = np.linalg.norm(moved - np.nanmean(moved, axis=0), axis=2)
    jitter = jitter_of(T_lab_face.inverse().apply(positions))
    error_mm = without_jitter(distance, jitter)
    return LeftOutError(
        left_out_mm=error_mm,
        left_out_share=missed(error_mm, without_jitter(motion, jitter)),
        carry_share=share,
        marker_mm=distance,
        marker_motion_mm=motion,
        jitter_mm=jitter,
        neutral_share=missed(error_mm, without_jitter(np.linalg.norm(moved, axis=2), jitter)),
    )


def jitter_of(positions: Float[np.ndarray, "frames markers 3"]) -> float:
    """rms distance of samples from where their markers are, mm, by the median of second differences over frames.

    Of independent samples of deviation s a second difference has s sqrt(6); skin that moves smoothly has next to none.
    """
    bent = np.abs(positions[2:] - 2 * positions[1:-1] + positions[:-2])
    bent = bent[np.isfinite(bent)]
    deviation = np.median(bent) / NORMAL_MEDIAN / np.sqrt(6) if len(bent) else 0.0
    return float(np.sqrt(3) * deviation)


def without_jitter(distances: Float[np.ndarray, "..."], jitter_mm: float) -> float:
    """rms of distances (NaN: unknown) less what jitter adds to it, mm; never less than half of their squares' mean is
    left, for skin that moves fast looks like jitter."""
    squared = float(np.nanmean(distances**2))
    return float(np.sqrt(max(squared - jitter_mm**2, squared / 2)))


def missed(off_mm: float, moved_mm: float) -> float:
    """The share of a motion that is missed; less motion than jitter counts as jitter."""
    return off_mm / max(moved_mm, LEAST_MOTION_MM)


def _tell_hidden(
    model: MarkerModel, X: np.ndarray, T: Transform, shown: np.ndarray, metric, solve: SolveConfig, covariance
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How far hidden markers are from where shapes, and where carried motion, put them, and off rest: (t, h, 3)."""
    few = MarkerModel(model.neutral[shown], model.shapes[:, shown])
    hidden = MarkerModel(model.neutral[~shown], model.shapes[:, ~shown])
    solved = solve_frames(few, X[:, shown], T, RATE, metric, solve)
    seen = solved.T_lab_face.inverse().apply(X)
    seen[~solved.tracked] = np.nan
    there = seen[:, ~shown]
    off, moved = there - hidden.points(solved.weights), there - hidden.neutral
    if covariance is None:
        return off, off, moved
    carry = covariance.carry(np.flatnonzero(shown), np.flatnonzero(~shown))
    known = np.where(np.isfinite(seen[:, shown]), seen[:, shown], few.points(solved.weights))
    motion = (known - few.neutral).reshape(len(known), -1)
    return off, moved - np.einsum("hac,tc->tha", carry, motion, optimize=True), moved


def _mean(vectors: np.ndarray) -> float:
    """Mean length of those that are known, mm."""
    return float(np.nanmean(np.linalg.norm(vectors, axis=-1)))


def folds(places: Float[np.ndarray, "markers 3"], count: int) -> np.ndarray:
    """A group for every marker, 0..count-1, each spread over the face: neighbours in height take turns."""
    group = np.empty(len(places), dtype=np.int64)
    group[np.argsort(places[:, 1], kind="stable")] = np.arange(len(places)) % count
    return group
