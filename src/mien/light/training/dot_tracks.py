"""Dots followed from frame to frame and from clip to clip: each keeps the label that it had in the neutral."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import cKDTree

from ...errors import BadInput
from ...mesh import ClosestPoint, Mesh
from ...register import IcpConfig, icp
from ..disk.light_scan import LightScan

NEIGHBOURS = 5
"""Matched dots whose motion says where a dot has gone."""
LEAST_SHARE = 0.3
"""Of the dots that must be found again; fewer and the frame is of something else."""


@dataclass(frozen=True)
class DotTrackConfig:
    """How far dots go."""

    reach_mm: float = 6.0
    """Between frames, of the dots that are matched first; below the distance of neighbouring dots."""
    slack_mm: float = 2.0
    """How far a dot may be from where its matched neighbours' motion says."""
    rounds: int = 10
    """In which matches spread from the dots that hardly move to those that move most."""


@dataclass(frozen=True)
class TrackedDots:
    """One frame's dots, under the neutral's labels."""

    positions: Float[np.ndarray, "k 3"]
    """Rig space, mm; a lost dot is where its neighbours' motion takes it."""
    seen: Bool[np.ndarray, " k"]


def follow_dots(
    before: Float[np.ndarray, "k 3"],
    found: Float[np.ndarray, "m 3"],
    config: DotTrackConfig = DotTrackConfig(),
    step: Float[np.ndarray, "k 3"] | None = None,
) -> TrackedDots:
    """Each dot's place in the next frame, looked for where it was, and where it would be had it gone on as before.

    The start from which more dots are found again is the right one: faces stop and turn.

    Args:
        step: how each dot went from the frame before the last to the last, mm; None: nothing is known.

    Raises:
        BadInput: hardly any is found again.
    """
    still = follow_from(before, found, config)
    ahead = None if step is None else follow_from(before + step, found, config)
    best = still if ahead is None or still.seen.sum() >= ahead.seen.sum() else ahead
    check_found(int(best.seen.sum()), len(before))
    return best


def follow_from(
    start: Float[np.ndarray, "k 3"], found: Float[np.ndarray, "m 3"], config: DotTrackConfig
) -> TrackedDots:
    """Near ones that agree with their neighbours, then the others round those; none where hardly any is near."""
    none = TrackedDots(start, np.zeros(len(start), bool))
    one, other = mutual_nearest(start, found, config.reach_mm)
    expected = start
    for _ in range(config.rounds):
        if not enough(len(one), len(start)):
            return none
        steps = found[other] - start[one]
        agree = np.linalg.norm(steps - neighbours_steps(start, one, steps)[one], axis=1) < config.slack_mm
        if not enough(int(agree.sum()), len(start)):
            return none
        expected = start + neighbours_steps(start, one[agree], steps[agree])
        one, other = mutual_nearest(expected, found, config.slack_mm)
    seen = np.zeros(len(start), bool)
    seen[one] = True
    positions = expected.copy()
    positions[one] = found[other]
    return TrackedDots(positions, seen)


def enough(count: int, total: int) -> bool:
    """Whether so many dots of all are enough to go by."""
    return count >= max(3, LEAST_SHARE * total)


def check_found(count: int, total: int) -> None:
    """Refuse a frame in which too few dots are found again.

    Raises:
        BadInput: it has too few.
    """
    if not enough(count, total):
        raise BadInput(f"dots: {count} of {total} are found again; is it the same face and dots?")


def mutual_nearest(
    points: Float[np.ndarray, "k 3"], others: Float[np.ndarray, "m 3"], reach_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of points and of others that are each other's nearest, within a reach."""
    if not len(points) or not len(others):
        return np.zeros(0, int), np.zeros(0, int)
    distance, there = cKDTree(others).query(points)
    _, back = cKDTree(points).query(others)
    one = np.flatnonzero((back[there] == np.arange(len(points))) & (distance < reach_mm))
    return one, there[one]


def neighbours_steps(
    before: Float[np.ndarray, "k 3"], matched: np.ndarray, steps: Float[np.ndarray, "m 3"]
) -> Float[np.ndarray, "k 3"]:
    """For every dot the median step of the matched ones round it: a wrong match among them does not count."""
    count = min(NEIGHBOURS, len(matched))
    _, near = cKDTree(before[matched]).query(before, k=count)
    return np.median(steps[near.reshape(len(before), count)], axis=1)


def moved_head(
    neutral: Float[np.ndarray, "k 3"], skin: Mesh, scan: LightScan, step: int = 4
) -> Float[np.ndarray, "k 3"]:
    """The neutral's dots where the head is at the start of another clip, by the two surfaces (ICP)."""
    points = scan.points[::step, ::step]
    points = points[np.isfinite(points).all(-1)]
    T_neutral_scan = icp(points, ClosestPoint(skin), config=IcpConfig(robust="tukey", tolerance=1e-2)).transform
    return T_neutral_scan.inverse().apply(neutral)
