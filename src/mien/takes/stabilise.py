"""Take the head's motion out of a marker take, with no marker known to be fixed to the skull."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..clip import Markers, visible
from ..errors import BadInput
from ..register import procrustes_frames
from ..transforms import Transform


@dataclass(frozen=True)
class StabiliseConfig:
    """How the skull is told from the skin."""

    iterations: int = 15
    """Rounds of alignment and reweighting."""
    still_mm: float = 0.3
    """A marker that moves less than this against the others gains no further weight by it."""
    still_share: float = 0.3
    """Share of the markers that count as still, so that no two or three of them take over."""
    robust_mm: float = 15.0
    """A sample this far from its marker's place in the head loses half of its say in its frame; inf: none does."""


@dataclass(frozen=True)
class Stabilised:
    """A take seen from its head."""

    markers: Markers
    """Positions in the head frame: face motion alone."""
    T_lab_head: Transform
    """Head pose, one a frame; frames with fewer than three markers hold the last one."""
    weights: Float[np.ndarray, " markers"]
    """How much each marker told of the head, 0..1: 1 is as still as the stillest."""


def stabilise(markers: Markers, config: StabiliseConfig = StabiliseConfig()) -> Stabilised:
    """Robust rigid alignment of all frames to one another, in which markers that move on the face lose weight.

    Iteratively reweighted generalised Procrustes analysis: the reference is the markers' median, a marker's weight
    the inverse of its squared spread about it. Gaps are left out frame by frame.

    Raises:
        BadInput: no frame shows three markers.
    """
    X, seen = markers.positions, markers.seen
    enough = seen.sum(axis=1) >= 3
    if not enough.any():
        raise BadInput("the take shows fewer than 3 markers in every frame; nothing can be aligned")
    reference = X[np.argmax(seen.sum(axis=1))]
    weights, trust = np.ones(X.shape[1]), np.ones(seen.shape)
    for _ in range(config.iterations):
        usable = seen & np.isfinite(reference).all(axis=1)
        T = procrustes_frames(np.nan_to_num(reference), X, usable * weights * trust).transform
        aligned = T.inverse().apply(X)
        aligned[~enough] = np.nan
        reference = _nanmedian(aligned)
        off = np.linalg.norm(aligned - reference, axis=2)
        trust = 1 / (1 + (np.nan_to_num(off) / config.robust_mm) ** 2)
        spread = _nanmedian(off)
        floor = max(config.still_mm, float(np.nanquantile(spread, config.still_share)))
        weights = np.nan_to_num(floor**2 / np.maximum(spread, floor) ** 2)
    T = hold(T, enough)
    return Stabilised(markers.with_positions(T.inverse().apply(X)), T, weights)


def hold(T: Transform, tracked: np.ndarray) -> Transform:
    """Poses with untracked frames replaced by the last tracked one before them (the first one after, at the start)."""
    return T[last_tracked(tracked)]


def last_tracked(tracked: np.ndarray) -> np.ndarray:
    """For every frame the tracked frame whose value it shows: the last one before it, or the first one after.

    Raises:
        BadInput: no frame is tracked.
    """
    known = np.flatnonzero(tracked)
    if not len(known):
        raise BadInput("no frame shows enough of the markers")
    return known[np.maximum(np.searchsorted(known, np.arange(len(tracked)), side="right") - 1, 0)]


def calm_frames(
    positions: Float[np.ndarray, "frames markers 3"], share: float = 0.03, most: int = 5, distinct_mm: float = 0.7
) -> list[int]:
    """The frames that the take dwells at most, best first, each `distinct_mm` or more from the others in the mean.

    `positions` are in the head frame, mm. Nothing is held as still, as long and as often as a face at rest, so the
    frame with `share` of all frames within the least distance comes first; held expressions follow.
    """
    seen = visible(positions)
    complete = np.flatnonzero(seen.sum(axis=1) >= max(3, 0.9 * seen.sum(axis=1).max()))
    sample = complete[np.linspace(0, len(complete) - 1, min(len(complete), 1000)).astype(int)]
    X = np.where(seen[sample][..., None], positions[sample], _nanmedian(positions)).reshape(len(sample), -1)
    X -= X.mean(axis=0)
    squared = (X**2).sum(axis=1)
    distances = np.sqrt(np.maximum(squared[:, None] + squared - 2 * X @ X.T, 0) / positions.shape[1])
    near = min(len(sample) - 1, max(3, round(share * len(sample))))
    chosen: list[int] = []
    for i in np.argsort(np.partition(distances, near, axis=1)[:, near], kind="stable"):
        if len(chosen) < most and all(distances[i, j] > distinct_mm for j in chosen):
            chosen.append(int(i))
    return [int(sample[i]) for i in chosen]


def mean_cloud(
    positions: Float[np.ndarray, "frames markers 3"], frame: int, most: int = 15
) -> Float[np.ndarray, "markers 3"]:
    """The markers at `frame`, averaged over the frames most like it: less jitter, fewer gaps. Head frame, mm."""
    reference = np.where(np.isfinite(positions[frame]), positions[frame], _nanmedian(positions))
    apart = np.linalg.norm(np.nan_to_num(positions - reference), axis=2)
    seen = visible(positions)
    distance = np.where(seen.any(axis=1), apart.sum(axis=1) / np.maximum(seen.sum(axis=1), 1), np.inf)
    nearest = np.argsort(distance, kind="stable")[: max(1, min(most, len(positions) // 50))]
    cloud = _nanmedian(positions[nearest])
    return np.where(np.isfinite(cloud), cloud, reference)


def _nanmedian(values: np.ndarray) -> np.ndarray:
    """Median over the first axis, NaN (and no warning) where there is nothing."""
    empty = ~np.isfinite(values).any(axis=0)
    return np.where(empty, np.nan, np.nanmedian(np.where(empty, 0.0, values), axis=0))
