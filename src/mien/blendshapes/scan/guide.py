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
MOST = 0.8
"""Quantile of the landmarks' distances that tells an expression from another: on a staged sensor 2 mm for the same face
from the front, 5 mm for a smile, 5 mm for the same face turned by 30 degrees, whose far side is guessed."""
FRONT_DEG, TELLING_DEG = 15.0, 25.0
"""A pose is begun within the first angle from the front; beyond the second nothing is said of the expression."""


@dataclass(frozen=True)
class GuideConfig:
    """When a pose is held, and when it has been seen enough."""

    still_s: float = 0.5
    """An expression is held once its landmarks have moved little for so long."""
    still_mm: float = 3.0
    """... by less than this within the head, four in five of them. (2 mm is their noise.)"""
    lost_mm: float = 6.0
    """A frame whose landmarks are so far from the held ones, by the same measure, does not count."""
    changed_mm: float = 4.0
    """A new pose differs by this from the one before ..."""
    patience_s: float = 4.0
    """... or has been asked for so long ago: closed eyes move too few landmarks."""
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
    yaw = yaw_deg(T_head_camera.rotation)
    if state.held is None and abs(yaw) > FRONT_DEG:
        return replace(state, candidate=None), Guided(f"{pose}: look straight at the sensor")
    if state.held is None:
        return _wait(state, frame, face, config)
    if abs(yaw) < TELLING_DEG and apart(face, state.held) > config.lost_mm:
        return state, Guided(f"{pose}: hold the expression")
    seen = {angle for angle in config.turns_deg if abs(angle - yaw) < config.near_deg}
    state = replace(state, kept=(*state.kept, frame), angles=state.angles | seen)
    return _enough(state, frame, config)


def _wait(state: GuideState, frame: RGBDFrame, face, config: GuideConfig) -> tuple[GuideState, Guided]:
    """Before the pose is held: still, and another than the one before."""
    pose = state.poses[0]
    asked = frame.time - (state.since or 0.0)
    same = state.before is not None and apart(face, state.before) < config.changed_mm
    if same and asked < config.patience_s:
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
    """How far two faces' landmarks lie apart within the head, the nearer four fifths of them, mm."""
    off = np.linalg.norm(one - other, axis=1)
    off = off[np.isfinite(off)]
    return float(np.quantile(off, MOST)) if len(off) else np.inf


def yaw_deg(R_head_camera: Float[np.ndarray, "3 3"]) -> float:
    """How far the head is turned to its left, seen from the sensor, degrees."""
    x, _, z = -R_head_camera[:, 2]
    return float(-np.degrees(np.arctan2(x, z)))
