"""The frames of a capture: which show the face, and where the head is in each (Casas et al. 2016, sec. 3)."""

from dataclasses import dataclass, field
from itertools import islice

import numpy as np
from jaxtyping import Float, Float32

from ...camera import Camera
from ...depth import RGBDFrame, median, unproject, window_around
from ...errors import BadInput
from ...landmarks.detector import FaceLandmarker
from ...landmarks.in_depth import lifted
from ...landmarks.look import similarity_to_average
from ...landmarks.stream import Landmarker, with_landmarks
from ...mesh import ClosestPoint, Mesh
from ...progress import SILENT, Progress
from ...register import procrustes_robust
from ...register.correspond import Rejection
from ...register.rigid_icp import IcpConfig, icp
from ...rgbd import RgbdTake
from ...transforms import Transform

SIZES = (0.6, 1.6)
"""A face so many times smaller or larger than the average one is depth in another unit."""
FACE_MM = 130.0
"""Depth farther than this from the middle of the landmarks is not the head."""
OFF_MARK_MM = 3.0
"""A landmark so far off its place counts a quarter."""
EDGE_MM = 6.0
"""Neighbouring depth pixels farther apart along the line of sight are two surfaces."""


@dataclass(frozen=True)
class FramesConfig:
    """Which frames are used, and how they are registered."""

    most: int = 40
    """Frames that are used, evenly over the take; fewer where it is shorter."""
    icp: IcpConfig = field(
        default_factory=lambda: IcpConfig(
            robust="tukey", rejection=Rejection(max_distance=8.0, max_angle_deg=180), iterations=12, tolerance=0.02,
            max_points=2500,
        )
    )  # fmt: skip
    """Each frame's points to the map so far, point to plane."""
    worst_mm: float = 1.5
    """A frame whose points stay farther from the map than this, weighted rms, is left out."""
    least_share: float = 0.35
    """... and one of which less than this share of the points finds the map."""
    still_mm: float = 5.0
    """A face whose landmarks move in the head by more than this, median, holds no expression. (2 mm is their noise.)"""


@dataclass(frozen=True)
class SeenFrame:
    """A frame with a face in it."""

    frame: RGBDFrame
    depth: Float32[np.ndarray, "h w"]
    """Without flying pixels, mm, 0 = none."""
    landmarks: Float[np.ndarray, "478 3"]
    """Camera space, mm; NaN without depth."""


@dataclass(frozen=True)
class PlacedFrame:
    """A frame whose head has been found."""

    seen: SeenFrame
    T_face_camera: Transform


def frames_with_face(
    take: RgbdTake,
    landmarker: Landmarker | None = None,
    config: FramesConfig = FramesConfig(),
    progress: Progress = SILENT,
) -> list[SeenFrame]:
    """The take's frames, thinned out evenly, in which a face is found and has depth.

    Raises:
        BadInput: a take without depth, or no frame with a face.
    """  # fmt: skip
    if not take.has_depth:
        raise BadInput(f"{take.name}: has no depth; a scan needs an RGB-D take")
    every = max(1, take.count // config.most)
    chosen = islice(iter(take), 0, None, every)
    seen = []
    for i, (frame, found) in enumerate(with_landmarks(chosen, landmarker or FaceLandmarker())):
        progress.update("looking for the face", min(i + 1, config.most), config.most)
        if found is None or frame.depth is None or frame.color is None:
            continue
        depth = median(np.nan_to_num(frame.depth))
        seen.append(SeenFrame(frame, depth, lifted(depth, found, take.camera)))
    seen = [one for one in seen if np.isfinite(one.landmarks[:, 0]).mean() > 0.5]
    if not seen:
        raise BadInput(f"{take.name}: no frame shows a face with depth; face the sensor, in light, and record again")
    return seen[: config.most]


def reference_frame(seen: list[SeenFrame], name: str) -> tuple[int, Transform]:
    """The frame that looks straightest at the sensor, and T_face_camera of it by its landmarks.

    Raises:
        BadInput: depth in another unit than the take says.
    """
    poses = [similarity_to_average(one.landmarks)[0] for one in seen]
    ahead = [pose.rotation[2, 2] for pose in poses]
    best = int(np.argmin(ahead))
    scale = poses[best].scale
    if not SIZES[0] < scale < SIZES[1]:
        raise BadInput(f"{name}: its depth makes a face {1 / scale:.2g} times a usual one's size; set --depth-scale")
    return best, similarity_to_average(seen[best].landmarks, scale=False)[0]


def place_by_landmarks(one: SeenFrame, reference: SeenFrame, T_face_reference: Transform) -> tuple[Transform, float]:
    """T_face_camera of a frame by its landmarks, and how far they moved in the head, rms mm."""
    known = np.isfinite(one.landmarks[:, 0]) & np.isfinite(reference.landmarks[:, 0])
    goal = T_face_reference.apply(reference.landmarks)
    found = procrustes_robust(one.landmarks, goal, [OFF_MARK_MM] * 5, known.astype(float))
    return found.transform, float(np.sqrt(np.median(found.residuals[known] ** 2)))


def place_by_surface(
    seen: SeenFrame, start: Transform, surface: ClosestPoint, camera: Camera, config: FramesConfig
) -> PlacedFrame | None:
    """The frame laid on the map so far by ICP; None where it does not fit."""
    points = start.apply(face_points(seen, camera))
    try:
        found = icp(points, surface, config=config.icp)
    except BadInput:
        return None
    used = min(len(points), config.icp.max_points or len(points))
    if found.rms > config.worst_mm or (found.weights > 0).sum() < config.least_share * used:
        return None
    return PlacedFrame(seen, found.transform @ start)


def face_points(seen: SeenFrame, camera: Camera) -> Float[np.ndarray, "p 3"]:
    """Depth points on and round the face, camera space, mm."""
    _, points, off = _near_face(seen, camera)
    return points[off < FACE_MM / 1.3].astype(np.float64)


def frame_mesh(placed: PlacedFrame, camera: Camera) -> tuple[Mesh, Float[np.ndarray, " m"]]:
    """A frame's depth as a surface in face space, mm, and each triangle's cosine to its line of sight."""
    depth, points, off = _near_face(placed.seen, camera)
    near = off < FACE_MM
    h, w = depth.shape
    index = np.arange(h * w).reshape(h, w)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]
    z, inside = depth.ravel(), near.ravel()
    quads = (inside[a] & inside[b] & inside[c] & inside[d]).ravel()
    corners = np.stack([a.ravel(), b.ravel(), c.ravel(), d.ravel()], 1)[quads]
    sights = z[corners.T]
    corners = corners[sights.max(0) - sights.min(0) < EDGE_MM]
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [2, 1, 3]]])
    used = np.zeros(h * w, bool)
    used[faces] = True
    local = points.reshape(-1, 3)[used].astype(np.float64)
    faces = (np.cumsum(used) - 1)[faces]
    return Mesh(placed.T_face_camera.apply(local), faces), _cosines(local, faces)


def _near_face(
    seen: SeenFrame, camera: Camera
) -> tuple[Float32[np.ndarray, "h w"], Float32[np.ndarray, "h w 3"], Float[np.ndarray, "h w"]]:
    """The depth round the face, its points, camera space, and their distance from the landmarks' middle; all mm."""
    middle = np.nanmedian(seen.landmarks, axis=0)
    corners = np.array([middle + side * FACE_MM * np.array([1.0, 1.0, 0.0]) for side in (-1, 1)])
    window = window_around(camera.project(corners), camera, margin=0, least=1)
    depth = window.crop(seen.depth)
    points = unproject(depth, window.camera(camera))
    x, y, z = np.moveaxis(points, -1, 0)
    off = np.sqrt((x - middle[0]) ** 2 + (y - middle[1]) ** 2 + (z - middle[2]) ** 2)
    return depth, points, np.nan_to_num(off, nan=np.inf)


def _cosines(local: np.ndarray, faces: np.ndarray) -> Float[np.ndarray, " m"]:
    a, b, c = (local[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    across = np.einsum("md,md->m", normal, a)
    size = np.sqrt(np.einsum("md,md->m", normal, normal) * np.einsum("md,md->m", a, a))
    return np.abs(across) / np.maximum(size, 1e-9)
