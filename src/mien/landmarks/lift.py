"""The face in any scan: any unit, any orientation, with texture or without; its landmarks on the scan's surface."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..faces.scan_clean import check_scan, evened, wound_alike
from ..mesh import Scan
from ..transforms import Transform
from .detector import FaceLandmarker
from .find_face import find_face, scan_name
from .half_face import completed, cut_planes
from .look import UNITS_MM, LiftConfig, look, similarity_to_average


@dataclass(frozen=True)
class Landmarks3D:
    """MediaPipe's 478 landmarks on a scan."""

    points: Float[np.ndarray, "478 3"]
    """In the scan's own frame and unit; NaN where no view had surface under the landmark."""
    disagreement: Float[np.ndarray, " 478"]
    """How far the views disagree (median distance from their median), mm; NaN where there is no point."""
    T_face_scan: Transform
    """Similarity: the scan's frame and unit -> face space, mm."""
    unit: str
    """The unit that was recognised: one of `UNITS_MM`, or "unknown" where the scale is only the average face's."""
    scores: dict[str, float]
    """Expression by ARKit names, 0..1: the views' median."""
    misfit: float
    """Median distance to the average face's landmarks, mm."""
    inside_out: bool
    """Whether the scan's triangles show their inner side to the viewer."""


def lift_landmarks(scan: Scan, config: LiftConfig | None = None) -> Landmarks3D:
    """Find the face in a scan and its landmarks on the surface.

    The scan is drawn from 24 axis-aligned orientations (then from 80 more if need be); what MediaPipe finds upright
    there is lifted to the surface by rays and compared with the average face in 3D, which no hollow or upside-down
    face survives. Then the face is looked at from the front and from a few sides: each landmark is the views' median.

    Raises:
        BadInput: no surface, no face, or more than one head.
    """
    config = config or LiftConfig()
    check_scan(scan)
    scan = replace(scan, mesh=evened(wound_alike(scan.mesh)))
    with FaceLandmarker(faces=3, confidence=0.4) as landmarker:
        try:
            whole = _landmarks(scan, landmarker, config)
        except BadInput as refused:
            half = _half(scan, landmarker, config)
            if half is None:
                raise refused
            return half
        if _plausible(whole):
            return whole
        return _half(scan, landmarker, config) or whole


LEAST_SEEN = 0.75
"""A face with fewer of its landmarks on the surface may be half a face, squeezed into a whole one."""
SIDEWAYS = 0.9
"""A cut runs along the middle of a face when its normal points to a side, by this cosine."""


def _landmarks(scan: Scan, landmarker: FaceLandmarker, config: LiftConfig) -> Landmarks3D:
    """Find the face, look from all views, settle the unit."""
    seen = look(scan, find_face(scan, landmarker, config), config.views, landmarker, config)
    if seen is None:
        name = scan_name(scan)
        raise BadInput(f"{name}: the face was lost on a closer look; crop the scan to the head and try again")
    T_face_scan, unit, misfit = _with_unit(seen.points, seen.T_face_scan, config)
    disagreement = seen.disagreement * T_face_scan.scale
    return Landmarks3D(seen.points, disagreement, T_face_scan, unit, seen.scores, misfit, seen.inside_out)


def _plausible(found: Landmarks3D) -> bool:
    """Whether it looks like a whole face of a known unit."""
    return found.unit != "unknown" and bool(np.isfinite(found.points[:, 0]).mean() > LEAST_SEEN)


def _half(scan: Scan, landmarker: FaceLandmarker, config: LiftConfig) -> Landmarks3D | None:
    """Landmarks of a scan that was cut along the middle of the face, on its own side alone; None where it was not."""
    for plane in cut_planes(scan.mesh):
        try:
            found = _landmarks(completed(scan, plane), landmarker, replace(config, zooms=()))
        except BadInput:
            continue
        across = found.T_face_scan.rotate(plane.normal[None])[0]
        if abs(across[0]) > SIDEWAYS and found.unit != "unknown":
            own = plane.height(np.nan_to_num(found.points)) >= 0
            points = np.where(own[:, None], found.points, np.nan)
            return replace(found, points=points, disagreement=np.where(own, found.disagreement, np.nan))
    return None


def landmarks_near(
    scan: Scan, T_face_scan: Transform, config: LiftConfig | None = None
) -> tuple[Float[np.ndarray, "478 3"], Float[np.ndarray, " 478"]] | None:
    """Landmarks of a scan in a known pose, and their disagreement (`Landmarks3D`); None where no view shows a face."""
    config = config or LiftConfig()
    scan = replace(scan, mesh=evened(scan.mesh))
    with FaceLandmarker(faces=3, confidence=0.4) as landmarker:
        seen = look(scan, T_face_scan, config.views, landmarker, config)
    return None if seen is None else (seen.points, seen.disagreement * T_face_scan.scale)


def _with_unit(points: np.ndarray, T_face_scan: Transform, config: LiftConfig) -> tuple[Transform, str, float]:
    """Take a known unit for the scale where the face's size allows it, and then the rigid fit with it."""
    name, mm = min(UNITS_MM.items(), key=lambda unit: abs(np.log(T_face_scan.scale / unit[1])))
    if max(T_face_scan.scale / mm, mm / T_face_scan.scale) > config.unit_slack:
        return T_face_scan, "unknown", similarity_to_average(points)[1]
    rigid, misfit = similarity_to_average(points * mm, scale=False)
    return rigid @ Transform(np.eye(3), np.zeros(3), mm), name, misfit
