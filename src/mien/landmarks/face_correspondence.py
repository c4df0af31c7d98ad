"""Which triangle of one face belongs to which of another, by the landmarks of both."""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.interpolate import RBFInterpolator
from scipy.spatial import KDTree

from ..register.rigid import procrustes
from ..rig import Rig
from ..rig.transfer import nearest_faces
from ..transforms import Transform
from .on_rig import IRISES, LandmarkMap, feature_points, landmarks_of

BELIEVED = 25.0
"""A landmark farther off than this, mm, after the two faces were laid on one another is misplaced."""
FADE = 60.0
"""Millimetres from the nearest landmark at which the bending has faded out."""


def match_faces(
    source: Rig, target: Rig, landmarks: tuple[LandmarkMap, LandmarkMap] | None = None
) -> Int[np.ndarray, " target_faces"]:
    """The source triangle that rules each target triangle: a correspondence for deformation transfer.

    The target is laid on the source by a similarity, then bent by a thin-plate spline through the landmarks; what then
    lies nearest belongs together. Away from all landmarks the bending fades: what a spline says there is a guess.

    Args:
        landmarks: of the source and of the target; found by looking at them where not given.

    Raises:
        BadInput: one of them does not look like a face, or landmarks cannot be looked for.
    """
    on_source, on_target = landmarks or (landmarks_of(source), landmarks_of(target))
    known = on_source.known & on_target.known
    known[IRISES.start :] = False
    goal = feature_points(on_source, source.neutral)[known]
    spots = feature_points(on_target, target.neutral)[known]
    similarity, sound = _laid(spots, goal)
    goal, spots = goal[sound], spots[sound]
    start = similarity.apply(spots)
    bend = RBFInterpolator(start, goal - start, smoothing=1.0, neighbors=60, degree=1)
    laid = similarity.apply(target.neutral.vertices)
    away = KDTree(start).query(laid)[0]
    near = away < FADE
    laid[near] += bend(laid[near]) * (1 + np.cos(np.pi * away[near] / FADE))[:, None] / 2
    return nearest_faces(source.neutral, target.neutral.with_vertices(laid))


def _laid(spots: Float[np.ndarray, "k 3"], goal: Float[np.ndarray, "k 3"]) -> tuple[Transform, Bool[np.ndarray, " k"]]:
    """The similarity spots -> goal that most agree on, and which do.

    On a head without eyeballs landmarks fall through the lids to the back of the skull.
    """
    similarity = procrustes(spots, goal, scale=True).transform
    for _ in range(30):
        away = np.linalg.norm(similarity.apply(spots) - goal, axis=1)
        weights = 1 / (1 + (away / max(float(np.median(away)), 1.0)) ** 2) ** 2
        similarity = procrustes(spots, goal, weights, scale=True).transform
    return similarity, np.linalg.norm(similarity.apply(spots) - goal, axis=1) < BELIEVED
