"""The same look at any scan: pictures of it from known places, MediaPipe's landmarks lifted back to its surface."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..faces.bundled import load_face
from ..mesh import Mesh, Scan, face_normals
from ..pictures.raycast import Hits, RayCaster
from ..pictures.render import Look, Renderer
from ..pictures.view import View, frontal_camera
from ..register import procrustes
from ..transforms import Transform
from .detector import COUNT, FaceLandmarker, bundled_landmarks

UNITS_MM = {"mm": 1.0, "cm": 10.0, "in": 25.4, "dm": 100.0, "m": 1000.0}
"""Units that a scan may be in, by how many millimetres they have."""


@dataclass(frozen=True)
class LiftConfig:
    """How a face is looked for and looked at."""

    sweep_pixels: int = 320
    """Side of the pictures in which the face is searched."""
    pixels: int = 640
    """Side of the pictures from which landmarks are taken."""
    views: tuple[tuple[float, float], ...] = (
        *((0.0, 0.0), (-0.25, 0.0), (0.25, 0.0), (0.0, 0.18), (0.0, -0.18), (-0.5, 0.05), (0.5, 0.05)),
    )
    """Yaw and pitch of those pictures, radians."""
    least_cosine: float = 0.3
    """A view counts for a landmark where it meets the surface at this cosine or more."""
    max_misfit: float = 6.5
    """A face's lifted landmarks, seen from the front, meet the average face's to this, median, mm. In the search, from
    anywhere, up to twice that is worth a closer look."""
    max_stray: float = 30.0
    """A landmark farther than this from the average face's went through a hole in the scan and is dropped, mm."""
    max_tilt_deg: float = 50.0
    """A detection counts only in pictures where the face stands upright to this, degrees."""
    unit_slack: float = 1.3
    """A known unit is taken where it makes the face at most so many times larger or smaller than the average one."""
    zooms: tuple[int, ...] = (2, 4)
    """A face not found in the whole picture is looked for in tiles of pictures so many times as large."""
    apart: float = 90.0
    """Faces farther apart than this are two heads, mm."""


PLAIN = Look(supersample=1, occlusion=0, softness=0.0)
"""Fast pictures: MediaPipe does not miss shadows."""


def lift_pixels(
    caster: RayCaster, view: View, pixels: Float[np.ndarray, "p 2"]
) -> tuple[Hits, Float[np.ndarray, "p 3"]]:
    """Points of the surface under pixels, NaN where there is none."""
    back = view.T_camera_face.inverse()
    directions = back.rotate(view.camera.rays(pixels))
    hits = caster.cast(np.broadcast_to(back.translation, directions.shape), directions)
    return hits, back.translation + directions * hits.distances[:, None]


def similarity_to_average(points: Float[np.ndarray, "478 3"], scale: bool = True) -> tuple[Transform, float]:
    """The similarity (rigid without `scale`) of lifted landmarks onto the bundled face's; the median distance, mm.

    Only landmarks that keep to the skin count; the worst quarter is left out.
    """
    landmarks = bundled_landmarks()
    stable = landmarks.stable
    target = landmarks.attachment.points(load_face().rig.neutral)[stable]
    source = points[stable]
    weights = np.isfinite(source).all(axis=1).astype(float)
    if weights.sum() < 20:
        return Transform.identity(), float("inf")
    for _ in range(3):
        found = procrustes(source, target, weights, scale=scale)
        distances = np.linalg.norm(found.transform.apply(source) - target, axis=1)
        weights = (distances <= np.nanquantile(distances, 0.75)).astype(float)
    return found.transform, float(np.nanmedian(distances))


@dataclass(frozen=True)
class SeenLandmarks:
    """Landmarks from pictures of the face at a known place, and the better place."""

    T_face_scan: Transform
    points: Float[np.ndarray, "478 3"]
    """Scan's frame and unit, as in `Landmarks3D`."""
    disagreement: Float[np.ndarray, " 478"]
    """Scan's unit."""
    scores: dict[str, float]
    inside_out: bool


def look(
    scan: Scan, T_face_scan: Transform, views, landmarker: FaceLandmarker, config: LiftConfig
) -> SeenLandmarks | None:
    """Pictures of the scan from `views` (yaw, pitch) round the face at `T_face_scan`; None where all show no face."""
    m = scan.mesh
    mesh = Mesh(T_face_scan.apply(m.vertices), m.faces, m.uv, m.uv_faces, m.colors)
    renderer, caster = Renderer(mesh, PLAIN, scan.texture), RayCaster(mesh)
    normals = face_normals(mesh.vertices, mesh.faces)
    frame = 1.15 * bundled_landmarks().attachment.points(load_face().rig.neutral)
    found, scores, inward = [], [], []
    for yaw, pitch in views:
        view = frontal_camera(mesh, config.pixels, yaw, pitch, frame=frame)
        for seen in landmarker.detect_all(renderer.draw(*view))[:1]:
            hits, points = lift_pixels(caster, view, seen.points)
            facing = _facing(view, hits, points, normals)
            side = -1.0 if np.median(facing) < 0 else 1.0
            found.append(np.where((side * facing >= config.least_cosine)[:, None], points, np.nan))
            scores.append(seen.scores)
            inward.append(side < 0)
    if not found:
        return None
    points, disagreement = _median(np.array(found))
    fresh = similarity_to_average(points)[0]
    stray = _off_average(fresh.apply(points)) > config.max_stray
    points[stray], disagreement[stray] = np.nan, np.nan
    back = T_face_scan.inverse()
    better = fresh @ T_face_scan
    names = {name: float(np.median([s[name] for s in scores])) for name in scores[0]}
    return SeenLandmarks(better, back.apply(points), disagreement * back.scale, names, bool(np.mean(inward) > 0.5))


def _off_average(points: Float[np.ndarray, "478 3"]) -> Float[np.ndarray, " 478"]:
    """Distance of each landmark (face space) from the average face's, mm; NaN where it is missing."""
    average = bundled_landmarks().attachment.points(load_face().rig.neutral)
    return np.linalg.norm(points - average, axis=1)


def _facing(view: View, hits: Hits, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Cosine between the surface's normal and the way to the camera; 0 where nothing was hit."""
    way = view.T_camera_face.inverse().translation - np.nan_to_num(points)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    return np.where(hits.hit, np.einsum("pd,pd->p", normals[hits.faces], way), 0.0)


def _median(stack: Float[np.ndarray, "views 478 3"]) -> tuple[np.ndarray, np.ndarray]:
    """Median over the views and the median distance from it; NaN where fewer than two views have the point.

    (Of a single view, one is enough.) What one view alone has often went through a hole.
    """
    points, disagreement = np.full((COUNT, 3), np.nan), np.full(COUNT, np.nan)
    seen = np.isfinite(stack).all(axis=2).sum(axis=0) >= min(2, len(stack))
    points[seen] = np.nanmedian(stack[:, seen], axis=0)
    disagreement[seen] = np.nanmedian(np.linalg.norm(stack[:, seen] - points[seen], axis=2), axis=0)
    return points, disagreement
