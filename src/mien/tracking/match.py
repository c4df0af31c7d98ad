"""Which triangle of one face belongs to which of another, by the landmarks of both."""

import numpy as np
from jaxtyping import Int
from scipy.interpolate import RBFInterpolator

from ..register.rigid import procrustes
from ..rig import Rig
from ..rig.transfer import nearest_faces
from .features import IRISES, LandmarkMap, feature_points, landmarks_of


def match_faces(
    source: Rig, target: Rig, landmarks: tuple[LandmarkMap, LandmarkMap] | None = None
) -> Int[np.ndarray, " target_faces"]:
    """The source triangle that rules each target triangle: a correspondence for deformation transfer.

    The target is laid on the source by a similarity, then bent by a thin-plate spline through the landmarks; what then
    lies nearest belongs together.

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
    similarity = procrustes(spots, goal, scale=True).transform
    start = similarity.apply(spots)
    bend = RBFInterpolator(start, goal - start, smoothing=1.0, neighbors=60, degree=1)
    laid = similarity.apply(target.neutral.vertices)
    near = np.linalg.norm(laid - goal.mean(0), axis=1) < 2.0 * np.linalg.norm(goal - goal.mean(0), axis=1).max()
    laid[near] += bend(laid[near])
    return nearest_faces(source.neutral, target.neutral.with_vertices(laid))
