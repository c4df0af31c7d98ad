"""A person's rig from a second or two of their calm face (Li et al. 2013, sec. 3)."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float

from ...camera import Camera
from ...depth import RGBDFrame
from ...errors import BadInput
from ...faces.bundled import BundledFace, load_face
from ...fitting.neutral import NeutralFitConfig, NeutralResult, fit_neutral
from ...landmarks.detector import FaceLandmarker, Landmarks2D
from ...landmarks.in_depth import lifted
from ...landmarks.on_rig import (
    LOWER_INNER_LIP,
    UPPER_INNER_LIP,
    LandmarkMap,
    attach_landmarks,
    feature_points,
    landmarks_of,
    lift,
)
from ...landmarks.stream import Landmarker
from ...mesh import Mesh
from ...one_line import count, one_line
from ...pictures.raycast import depth_image
from ...progress import SILENT, Progress
from ...rgbd import RgbdTake
from ...rig import Rig
from ...rig.transfer import merged, transfer_rig
from ...transforms import Transform
from ..detect import WrongScale, detect
from ..model import tracking_model
from .aggregate import Aggregate, AggregateConfig, aggregate
from .calm_frames import Neutrality, calm_frames, with_scale

VIEWS = 12
"""Frames from which the landmarks' places on the neutral are taken, about."""


@dataclass(frozen=True)
class PersonalizeConfig:
    """Making a person's rig."""

    first: int = 0
    """The first frame of the calm face."""
    frames: int = 45
    """How many frames are merged; fewer where the take is shorter."""
    shapes: Literal["arkit", "facs23"] = "arkit"
    """All 52 expressions, or the paper's 23 (`mien.rig.transfer.FACS23`)."""
    aggregate: AggregateConfig = field(default_factory=AggregateConfig)
    identity: NeutralFitConfig = field(default_factory=NeutralFitConfig)


@dataclass(frozen=True)
class Personal:
    """A person's rig and what is known of how it was made."""

    rig: Rig
    landmarks: LandmarkMap
    """Where MediaPipe sees its landmarks on this very face."""
    scan: Mesh
    """The merged depth, in face space, mm."""
    neutral: NeutralResult
    frame_distance: float
    """Mean distance of the frames from the merged scan, mm."""
    merged: int
    """Frames that went into the scan."""
    neutrality: Neutrality
    """How neutral the face was in them."""

    def __repr__(self) -> str:
        return one_line(self, self.rig, f"{count(self.merged, 'frames')} merged")


def personalize(
    take: RgbdTake,
    landmarker: Landmarker | None = None,
    config: PersonalizeConfig = PersonalizeConfig(),
    face: BundledFace | None = None,
    generic: LandmarkMap | None = None,
    progress: Progress = SILENT,
) -> Personal:
    """Merge calm frames, fit the identity space, shrink-wrap, transfer the expressions, attach the landmarks.

    Args:
        generic: where the landmarks are on `face`, the bundled one by default; found by looking at it if not given.

    Raises:
        BadInput: no depth, no face in the first 30 frames, a depth scale that makes no face, frames that do not hold
            still.
    """
    if not take.has_depth:
        raise BadInput(f"{take.name}: has no depth; a person's rig needs an RGB-D take")
    face = face or load_face()
    generic = generic or landmarks_of(face.rig)
    looking = landmarker or FaceLandmarker("video")
    frames, found, neutrality = calm_frames(take, looking, config.first, config.frames, progress)
    try:
        T_camera_face = detect(tracking_model(face.rig, generic), frames[0], found[0], take.camera)
    except WrongScale as error:
        raise with_scale(error, take) from error
    scanned = aggregate(frames, take.camera, T_camera_face, config.aggregate, progress)
    seen = landmarks_on_scan(scanned, frames, found, take.camera)
    eye = T_camera_face.inverse().translation
    neutral = fit_neutral(face, generic, scanned.scan, seen, eye, config.identity)
    expressions = face.rig if config.shapes == "arkit" else merged(face.rig)
    rig = transfer_rig(expressions, neutral.mesh)
    landmarks = own_landmarks(rig, generic, scanned, neutral.T_scan_face, found, take.camera)
    home = neutral.T_scan_face.inverse()
    merged_scan = home.apply(scanned.scan.vertices)
    return Personal(
        rig=rig,
        landmarks=landmarks,
        scan=scanned.scan.with_vertices(merged_scan),
        neutral=neutral,
        frame_distance=scanned.frame_distance,
        merged=sum(pose is not None for pose in scanned.T_camera_face),
        neutrality=neutrality,
    )


def landmarks_on_scan(
    scanned: Aggregate, frames: list[RGBDFrame], found: list[Landmarks2D], camera: Camera
) -> Float[np.ndarray, "478 3"]:
    """Each landmark's median place over the frames, in the scan's space, mm; NaN where depth never showed it."""
    places = []
    for pose, frame, landmarks in zip(scanned.T_camera_face, frames, found, strict=True):
        if pose is None or frame.depth is None:
            continue
        in_camera = lifted(frame.depth, landmarks, camera)
        T_scan_camera = pose.inverse()
        places.append(T_scan_camera.apply(in_camera))
    return _median(np.stack(places))


def own_landmarks(
    rig: Rig, generic: LandmarkMap, scanned: Aggregate, T_scan_face: Transform, found, camera: Camera
) -> LandmarkMap:
    """Where the landmarks were seen on the person's neutral face, median over up to twelve frames.

    The inner lips stay where they are on the generic face: on a closed mouth both are seen on one line.
    """
    both = zip(scanned.T_camera_face, found, strict=True)
    placed = [(pose, marks) for pose, marks in both if pose is not None]
    apart = max(len(placed) // VIEWS, 1)
    seen = []
    for pose, marks in placed[::apart]:
        T_camera_face = pose @ T_scan_face
        image = depth_image(rig.neutral, camera, T_camera_face)
        lifted_marks = lift(marks.points, image, rig.neutral)
        seen.append(lifted_marks)
    points = _median(np.stack(seen))
    start = feature_points(generic, rig.neutral)
    points = np.where(np.isfinite(points), points, start)
    inner = [*UPPER_INNER_LIP, *LOWER_INNER_LIP]
    points[inner] = start[inner]
    found_here = np.isfinite(points[:, 0])
    known = generic.known & found_here
    points = np.nan_to_num(points)
    return attach_landmarks(rig.neutral, points, known)


def _median(places: np.ndarray) -> np.ndarray:
    """Median over the first axis of (frames, 478, 3), leaving NaN out; NaN where there is nothing else."""
    finite = np.isfinite(places[..., 0])
    known = finite.any(0)
    out = np.full(places.shape[1:], np.nan)
    seen = places[:, known]
    out[known] = np.nanmedian(seen, axis=0)
    return out
