"""Guided capture: what to do next, said while a sensor looks on (after Casas et al. 2016: no operator, 15 s a pose).

One pose after the other: hold the expression, then turn the head; frames count while the face holds still within the
head, and enough is when every angle has been seen. All by landmarks, so that each frame costs next to nothing.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ...camera import Camera
from ...depth import RGBDFrame
from ...landmarks.in_depth import lifted
from ...landmarks.look import similarity_to_average
from ...landmarks.stream import Landmarker, with_landmarks

POSES = ("neutral", "smile", "jawOpen", "brows_up", "frown", "mouthPucker", "mouthLeft", "eyes_closed")
"""The expressions of a session."""
TOP = 0.1
"""Share of the landmarks that tell an expression from another: those that moved most."""


@dataclass(frozen=True)
class GuideConfig:
    """When a pose is held, and when it has been seen enough."""

    still_s: float = 0.5
    """An expression is held once its landmarks have moved little for so long."""
    still_mm: float = 3.5
    """... by less than this within the head, mean of the tenth that moved most. (2 mm is their noise.)"""
    lost_mm: float = 6.0
    """A frame whose landmarks are so far from the held ones, by the same measure, does not count."""
    changed_mm: float = 4.0
    """A new pose differs by this from the one before."""
    turns_deg: tuple[float, ...] = (-20.0, -10.0, 0.0, 10.0, 20.0)
    """Angles of the head that are to be seen, to the subject's left above 0."""
    near_deg: float = 6.0
    """An angle counts as seen this near to it."""
    least: int = 8
    """Frames of a pose, at least."""
    longest_s: float = 15.0
    """A pose that has its least frames ends after so long, whatever was seen."""


@dataclass(frozen=True)
class GuideState:
    """How far a session is."""

    poses: tuple[str, ...]
    """Still to come, the present one first."""
    kept: tuple[RGBDFrame, ...] = ()
    """Frames of the present pose."""
    held: Float[np.ndarray, "478 3"] | None = None
    """Its landmarks within the head, mm; None until it is held."""
    before: Float[np.ndarray, "478 3"] | None = None
    """Those of the pose before."""
    candidate: tuple[float, Float[np.ndarray, "478 3"]] | None = None
    """Since when, s, the face has been as it is."""
    since: float | None = None
    """When the pose was asked for, s."""
    angles: frozenset[float] = frozenset()
    """Of `turns_deg`, those seen."""


@dataclass(frozen=True)
class Guided:
    """What one frame led to."""

    say: str
    finished: str | None = None
    """A pose that has been seen enough."""
    frames: tuple[RGBDFrame, ...] = ()
    """Its frames."""


def guide(
    frames: Iterable[RGBDFrame],
    camera: Camera,
    landmarker: Landmarker,
    poses: tuple[str, ...] = POSES,
    config: GuideConfig = GuideConfig(),
) -> Iterator[Guided]:
    """What to say after each frame, until all poses have been seen or the frames end."""
    state = GuideState(poses)
    for frame, found in with_landmarks(frames, landmarker, ahead=0):
        points = None
        if found is not None and frame.depth is not None:
            points = lifted(np.nan_to_num(frame.depth), found, camera)
        state, told = guide_step(state, frame, points, config)
        yield told
        if not state.poses:
            return


def guide_step(
    state: GuideState, frame: RGBDFrame, points: Float[np.ndarray, "478 3"] | None, config: GuideConfig
) -> tuple[GuideState, Guided]:
    """One frame more; `points` are its landmarks in camera space, mm, NaN without depth; None: no face."""
    pose = state.poses[0]
    state = replace(state, since=frame.time if state.since is None else state.since)
    if points is None or np.isfinite(points[:, 0]).mean() < 0.5:
        return replace(state, candidate=None), Guided(f"{pose}: no face is seen; face the sensor")
    T_head_camera = similarity_to_average(points, scale=False)[0]
    face = T_head_camera.apply(points)
    if state.held is None:
        return _wait(state, frame, face, config)
    if apart(face, state.held) > config.lost_mm:
        return state, Guided(f"{pose}: hold the expression")
    yaw = yaw_deg(T_head_camera.rotation)
    seen = {angle for angle in config.turns_deg if abs(angle - yaw) < config.near_deg}
    state = replace(state, kept=(*state.kept, frame), angles=state.angles | seen)
    return _enough(state, frame, config)


def _wait(state: GuideState, frame: RGBDFrame, face, config: GuideConfig) -> tuple[GuideState, Guided]:
    """Before the pose is held: still, and another than the one before."""
    pose = state.poses[0]
    if state.before is not None and apart(face, state.before) < config.changed_mm:
        return replace(state, candidate=None), Guided(f"{pose}: make it now, and hold it")
    if state.candidate is None or apart(face, state.candidate[1]) > config.still_mm:
        return replace(state, candidate=(frame.time, face)), Guided(f"{pose}: hold still")
    if frame.time - state.candidate[0] < config.still_s:
        return state, Guided(f"{pose}: hold still")
    state = replace(state, held=face, kept=(frame,), candidate=None)
    return state, Guided(f"{pose}: now turn the head slowly to both sides")


def _enough(state: GuideState, frame: RGBDFrame, config: GuideConfig) -> tuple[GuideState, Guided]:
    """Whether the pose has been seen from every side, or for long enough."""
    pose, *others = state.poses
    missing = [angle for angle in config.turns_deg if angle not in state.angles]
    late = frame.time - (state.since or 0.0) > config.longest_s
    if len(state.kept) < config.least or (missing and not late):
        side = "left" if missing and missing[-1] > 0 else "right"
        way = f"turn to your {side}" if missing else "go on"
        return state, Guided(f"{pose}: {way}, {len(state.kept)} frames")
    following = f"now {others[0]}" if others else "all is captured"
    told = Guided(f"{pose}: {len(state.kept)} frames; {following}", pose, state.kept)
    return GuideState(tuple(others), before=state.held), told


def apart(one: Float[np.ndarray, "478 3"], other: Float[np.ndarray, "478 3"]) -> float:
    """How far two faces' landmarks lie apart within the head, mean of the tenth that lies farthest, mm."""
    off = np.linalg.norm(one - other, axis=1)
    off = np.sort(off[np.isfinite(off)])
    return float(off[-max(1, round(TOP * len(off))) :].mean()) if len(off) else np.inf


def yaw_deg(R_head_camera: Float[np.ndarray, "3 3"]) -> float:
    """How far the head is turned to its left, seen from the sensor, degrees."""
    x, _, z = -R_head_camera[:, 2]
    return float(-np.degrees(np.arctan2(x, z)))
