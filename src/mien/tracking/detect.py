"""Where the head is, from landmarks alone: at the start, and after it was lost (Li et al. 2013, sec. 4.1)."""

import numpy as np
from jaxtyping import Float, Int

from ..camera import Camera
from ..depth import RGBDFrame
from ..errors import BadInput
from ..landmarks.detector import Landmarks2D
from ..landmarks.in_depth import lifted
from ..landmarks.on_rig import IRISES
from ..register import procrustes, procrustes_robust
from ..transforms import Transform
from .model import TrackingModel
from .rigid import LEVER, moved
from .terms.features import landmark_rows

EYE_CORNERS = [33, 263]
PLAUSIBLE = (0.6, 1.6)
"""A face whose eyes are farther apart or nearer than the rig's by these factors is another unit, not another person."""

FACE_WIDTH = 1.7
"""A face is so many times as wide as its outer eye corners are apart."""
ENOUGH_LANDMARKS = 20
"""Landmarks with depth that place a head."""
ROUNDS_IN_DEPTH, ROUNDS_IN_IMAGE = 5, 8
"""Solves with new robust weights: both have come to rest well before."""
STRAY_MM = 6.0
"""A landmark this far off its place counts a quarter, or half in the image: people differ by 2 to 4 mm."""


class WrongScale(BadInput):
    """Depth that makes no face of human size."""

    def __init__(self, wide: float, factor: float):
        super().__init__(
            f"depth scale: it makes a face {length(wide)} wide; multiply depth_scale (units a metre) by {factor:.3g} "
            f"to make it one of {length(wide / factor)}"
        )
        self.wide = wide
        """How wide the face is, mm."""
        self.factor = factor
        """What the take's units a metre should be multiplied by."""


def length(mm: float) -> str:
    """A length in words."""
    return f"{mm / 1000:.2f} m" if mm >= 500 else f"{mm:.0f} mm" if mm >= 10 else f"{mm:.2g} mm"


def detect(model: TrackingModel, frame: RGBDFrame, landmarks: Landmarks2D, camera: Camera) -> Transform:
    """T_camera_face that puts the neutral's landmarks on the detected ones.

    The landmarker's own rough depth gives the turn; the true depth under the landmarks, where there is any, gives the
    place, and refines both by Procrustes with points that lie off losing weight.

    Raises:
        BadInput: the depth image makes the face several times too large or too small.
    """
    T_camera_face = _reprojected(model, landmarks, camera, _rough(model, landmarks, camera))
    if frame.depth is None:
        return T_camera_face
    seen = lifted(frame.depth, landmarks, camera)
    if model.landmarks.known[EYE_CORNERS].all():
        check_size(model, seen)
    ids = np.flatnonzero(model.landmarks.known & np.isfinite(seen[:, 2]))
    if len(ids) < ENOUGH_LANDMARKS:
        return T_camera_face
    return procrustes_robust(model.landmark_neutral[ids], seen[ids], [STRAY_MM] * ROUNDS_IN_DEPTH).transform


def check_size(model: TrackingModel, seen: Float[np.ndarray, "478 3"]) -> None:
    """See that the depth's unit makes a face of the rig's size.

    Raises:
        BadInput: it does not; the line says what scale would.
    """
    right, left = seen[EYE_CORNERS]
    span = float(np.linalg.norm(left - right))
    if not np.isfinite(span) or PLAUSIBLE[0] < span / model.scale_mm < PLAUSIBLE[1]:
        return
    raise WrongScale(FACE_WIDTH * span, span / model.scale_mm)


def _rough(model: TrackingModel, landmarks: Landmarks2D, camera: Camera) -> Transform:
    """Turn and size from the landmarker's 3D guess, seen as a weak perspective image."""
    ids = _seen(model, landmarks)
    ids = ids[ids < IRISES.start]
    guess = np.column_stack([landmarks.points, landmarks.depth])[ids]
    fitted = procrustes(model.landmark_neutral[ids], guess, scale=True).transform
    focal = (camera.fx + camera.fy) / 2
    z = focal / fitted.scale
    ray = camera.rays(fitted.apply(model.centre[None])[0, :2])
    return Transform(fitted.rotation, ray * z - fitted.rotation @ model.centre)


def _reprojected(model: TrackingModel, landmarks: Landmarks2D, camera: Camera, T: Transform) -> Transform:
    """Gauss-Newton on the landmarks' reprojection, the face kept neutral; far-off landmarks lose weight."""
    ids = _seen(model, landmarks)
    rays = camera.rays(landmarks.points[ids])[:, :2]
    still = np.zeros(model.shapes)
    for _ in range(ROUNDS_IN_IMAGE):
        centre = T.apply(model.centre[None])[0]
        J, points = landmark_rows(model, ids, still, T, centre)
        J = J[:, :, model.shapes :]
        rows = J[:, :2] - rays[:, :, None] * J[:, 2:]
        right = rays * points[:, 2:] - points[:, :2]
        root = 1 / (1 + (right**2).sum(1) / STRAY_MM**2)
        rows, right = (rows * root[:, None, None]).reshape(-1, 6), (right * root[:, None]).ravel()
        motion = np.linalg.lstsq(rows, right, rcond=None)[0]
        motion[:3] /= LEVER
        T = moved(T, motion, centre)
    return T


def _seen(model: TrackingModel, landmarks: Landmarks2D) -> Int[np.ndarray, " j"]:
    """Landmarks that are known on the rig and are numbers in the image."""
    numbers = np.isfinite(landmarks.points).all(1) & np.isfinite(landmarks.depth)
    return np.flatnonzero(model.landmarks.known & numbers)
