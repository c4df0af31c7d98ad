"""The face in any scan: any unit, any orientation, with texture or without; its landmarks on the scan's surface."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from jaxtyping import Float

from ..camera import Camera
from ..errors import BadInput
from ..faces.bundled import load_face
from ..faces.scan_clean import check_scan, wound_alike
from ..mesh import Mesh, Scan, face_normals
from ..pictures.raycast import Hits, RayCaster
from ..pictures.render import Look, Renderer
from ..pictures.view import View, frontal_camera
from ..register import procrustes
from ..transforms import Transform
from .detector import COUNT, FaceLandmarker, Landmarks2D, bundled_landmarks

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
    apart: float = 90.0
    """Faces farther apart than this are two heads, mm."""


@dataclass(frozen=True)
class Landmarks3D:
    """MediaPipe's 478 landmarks on a scan."""

    points: Float[np.ndarray, "478 3"]
    """In the scan's own frame and unit; NaN where no view had surface under the landmark."""
    spread: Float[np.ndarray, " 478"]
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
    scan = replace(scan, mesh=wound_alike(scan.mesh))
    with FaceLandmarker(faces=3, confidence=0.4) as landmarker:
        seen = _look(scan, _find(scan, landmarker, config), config.views, landmarker, config)
    if seen is None:
        raise BadInput(f"{_name(scan)}: the face was lost on a closer look; crop the scan to the head and try again")
    T_face_scan, unit, misfit = _with_unit(seen.points, seen.T_face_scan, config)
    spread = seen.spread * T_face_scan.scale
    return Landmarks3D(seen.points, spread, T_face_scan, unit, seen.scores, misfit, seen.inside_out)


def landmarks_near(
    scan: Scan, T_face_scan: Transform, config: LiftConfig | None = None
) -> tuple[Float[np.ndarray, "478 3"], Float[np.ndarray, " 478"]] | None:
    """Landmarks of a scan in a known pose: (points, spread) as in `Landmarks3D`; None where no view shows a face."""
    config = config or LiftConfig()
    with FaceLandmarker(faces=3, confidence=0.4) as landmarker:
        seen = _look(scan, T_face_scan, config.views, landmarker, config)
    return None if seen is None else (seen.points, seen.spread * T_face_scan.scale)


@dataclass(frozen=True)
class _Candidate:
    """A detection that may be a face."""

    T_face_scan: Transform
    misfit: float
    """Median distance to the average face's landmarks, mm."""


def _find(scan: Scan, landmarker: FaceLandmarker, config: LiftConfig) -> Transform:
    """Roughly where the face is."""
    vertices = scan.mesh.vertices[np.unique(scan.mesh.faces)]
    centre = (vertices.min(0) + vertices.max(0)) / 2
    radius = float(np.linalg.norm(vertices - centre, axis=1).max())
    if not radius > 0:
        raise BadInput(f"{_name(scan)}: all vertices are in one point; give a scan of a face")
    sphere = Transform(np.eye(3), -centre / radius, 1 / radius)
    ball = replace(scan.mesh, vertices=sphere.apply(scan.mesh.vertices))
    renderer = Renderer(ball, _PLAIN, scan.texture)
    caster = RayCaster(ball)
    for rotations in (_axis_rotations(), _other_rotations()):
        found = [c for R in rotations for c in _candidates(renderer, caster, R, landmarker, config)]
        best = None
        for candidate in sorted(found, key=lambda c: c.misfit)[:8]:
            start = candidate.T_face_scan @ sphere
            if best is not None and _apart(start, best) < config.apart:
                continue
            seen = _look(scan, start, config.views[:1], landmarker, config)
            if seen is None or similarity_to_average(seen.points)[1] > config.max_misfit:
                continue
            if best is not None and _apart(seen.T_face_scan, best) > config.apart:
                apart = _apart(seen.T_face_scan, best)
                raise BadInput(f"{_name(scan)}: two heads, {apart:.0f} mm apart; crop the scan to one of them")
            best = best or seen.T_face_scan
        if best is not None:
            return best
    raise BadInput(f"{_name(scan)}: no face found from any side; check that it shows a face, or crop it to the head")


_PLAIN = Look(supersample=1, occlusion=0, softness=0.0)


def _name(scan: Scan) -> str:
    return scan.name or "scan"


def _apart(T_face_scan: Transform, T_other_scan: Transform) -> float:
    """Distance between two faces' middles as the second measures it, mm."""
    middle = np.array([[0.0, -20.0, 90.0]])
    return float(np.linalg.norm((T_other_scan @ T_face_scan.inverse()).apply(middle) - middle))


def _candidates(
    renderer: Renderer, caster: RayCaster, rotation: np.ndarray, landmarker: FaceLandmarker, config: LiftConfig
) -> list[_Candidate]:
    """Plausible faces in the four upright-and-turned pictures from one direction (unit ball at the origin)."""
    size = config.sweep_pixels
    camera = Camera(1.75 * size, 1.75 * size, (size - 1) / 2, (size - 1) / 2, size, size)
    view = View(camera, Transform(rotation, np.array([0.0, 0.0, 3.7])))
    image = renderer.draw(*view)
    found = []
    for turns in range(4):
        for seen in landmarker.detect_all(np.ascontiguousarray(np.rot90(image, turns))):
            if _tilt_deg(seen) > config.max_tilt_deg:
                continue
            hits, points = _lift(caster, view, _turned_back(seen.points, turns, size))
            T_face_ball, misfit = similarity_to_average(points)
            if hits.hit.mean() > 0.5 and misfit < 2 * config.max_misfit:
                found.append(_Candidate(T_face_ball, misfit))
    return found


def _turned_back(points: np.ndarray, turns: int, size: int) -> np.ndarray:
    """Pixels of an image that `np.rot90` turned, in the image before."""
    for _ in range(turns):
        points = np.stack([size - 1 - points[:, 1], points[:, 0]], 1)
    return points


def _tilt_deg(seen: Landmarks2D) -> float:
    """Angle between the face's up (chin to forehead) and the picture's."""
    up = seen.points[10] - seen.points[152]
    return float(np.degrees(np.abs(np.arctan2(up[0], -up[1]))))


def _lift(caster: RayCaster, view: View, pixels: Float[np.ndarray, "p 2"]) -> tuple[Hits, Float[np.ndarray, "p 3"]]:
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
class _Seen:
    """Landmarks from pictures of the face at a known place, and the better place."""

    T_face_scan: Transform
    points: Float[np.ndarray, "478 3"]
    """Scan's frame and unit, as in `Landmarks3D`."""
    spread: Float[np.ndarray, " 478"]
    """Scan's unit."""
    scores: dict[str, float]
    inside_out: bool


def _look(
    scan: Scan, T_face_scan: Transform, views, landmarker: FaceLandmarker, config: LiftConfig
) -> _Seen | None:
    """Pictures of the scan from `views` (yaw, pitch) round the face at `T_face_scan`; None where all show no face."""
    m = scan.mesh
    mesh = Mesh(T_face_scan.apply(m.vertices), m.faces, m.uv, m.uv_faces, m.colors)
    renderer, caster = Renderer(mesh, _PLAIN, scan.texture), RayCaster(mesh)
    normals = face_normals(mesh.vertices, mesh.faces)
    frame = 1.15 * bundled_landmarks().attachment.points(load_face().rig.neutral)
    found, scores, inward = [], [], []
    for yaw, pitch in views:
        view = frontal_camera(mesh, config.pixels, yaw, pitch, frame=frame)
        for seen in landmarker.detect_all(renderer.draw(*view))[:1]:
            hits, points = _lift(caster, view, seen.points)
            facing = _facing(view, hits, points, normals)
            side = -1.0 if np.median(facing) < 0 else 1.0
            found.append(np.where((side * facing >= config.least_cosine)[:, None], points, np.nan))
            scores.append(seen.scores)
            inward.append(side < 0)
    if not found:
        return None
    points, spread = _median(np.array(found))
    fresh = similarity_to_average(points)[0]
    stray = _off_average(fresh.apply(points)) > config.max_stray
    points[stray], spread[stray] = np.nan, np.nan
    back = T_face_scan.inverse()
    better = fresh @ T_face_scan
    names = {name: float(np.median([s[name] for s in scores])) for name in scores[0]}
    return _Seen(better, back.apply(points), spread * back.scale, names, bool(np.mean(inward) > 0.5))


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
    points, spread = np.full((COUNT, 3), np.nan), np.full(COUNT, np.nan)
    seen = np.isfinite(stack).all(axis=2).sum(axis=0) >= min(2, len(stack))
    points[seen] = np.nanmedian(stack[:, seen], axis=0)
    spread[seen] = np.nanmedian(np.linalg.norm(stack[:, seen] - points[seen], axis=2), axis=0)
    return points, spread


def _with_unit(points: np.ndarray, T_face_scan: Transform, config: LiftConfig) -> tuple[Transform, str, float]:
    """Take a known unit for the scale where the face's size allows it, and then the rigid fit with it."""
    name, mm = min(UNITS_MM.items(), key=lambda unit: abs(np.log(T_face_scan.scale / unit[1])))
    if max(T_face_scan.scale / mm, mm / T_face_scan.scale) > config.unit_slack:
        return T_face_scan, "unknown", similarity_to_average(points)[1]
    rigid, misfit = similarity_to_average(points * mm, scale=False)
    return rigid @ Transform(np.eye(3), np.zeros(3), mm), name, misfit


def _axis_rotations() -> list[np.ndarray]:
    """Camera rotations that look along the six axes."""
    return [_looking(np.array(axis, float)) for axis in (*np.eye(3), *-np.eye(3))]


def _other_rotations() -> list[np.ndarray]:
    """... along the twelve edges and eight corners of a cube."""
    ways = [np.array(w, float) for w in product((-1, 0, 1), repeat=3) if np.count_nonzero(w) >= 2]
    return [_looking(w / np.linalg.norm(w)) for w in ways]


def _looking(forward: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    """World -> camera rotation that looks along `forward`, with +Y (else +Z) up."""
    up = np.array([0.0, 1, 0]) if abs(forward[1]) < 0.9 else np.array([0.0, 0, 1])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])
