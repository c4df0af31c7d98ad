"""Where the face is in a scan: from all sides, then in tiles of larger pictures, then as one half of a face."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from jaxtyping import UInt8

from ..camera import Camera
from ..errors import BadInput
from ..mesh import Scan, connected_parts, submesh
from ..pictures.raycast import RayCaster
from ..pictures.render import Renderer
from ..pictures.view import View
from ..transforms import Transform, rotation_looking_along
from .detector import FaceLandmarker, Landmarks2D
from .look import PLAIN, LiftConfig, lift_pixels, look, similarity_to_average


@dataclass(frozen=True)
class _Candidate:
    """A detection that may be a face."""

    T_face_scan: Transform
    misfit: float
    """Median distance to the average face's landmarks, mm."""


CANDIDATES = 8
"""So many candidates of a pass, best first, get a closer look."""
FOCAL = 1.75
"""Focal length of the search's camera in widths of its picture."""
AWAY = 3.7
"""... and how far it stands from the middle of the scan, in radii: the scan fills 95 % of the picture."""
BLANK = 3.0
"""A tile whose grey values deviate by less (of 255) shows nothing."""
LEAST_HIT = 0.5
"""Share of its landmarks under which a candidate must have surface."""


LEAST_PART = 300
"""A piece of a scan with fewer vertices is no face."""
MOST_PARTS = 6
"""So many pieces, largest first, are searched by themselves."""


def find_face(scan: Scan, landmarker: FaceLandmarker, config: LiftConfig) -> Transform:
    """Roughly where the face is: T_face_scan.

    The whole scan is looked at from the axes, then from between them; then each of its pieces; then tiles of larger
    pictures, for a face that is small in what was scanned.

    Raises:
        BadInput: no face, or two heads.
    """
    axes = _axis_rotations()
    parts = [(part, axes, 1) for part in _parts(scan)] if config.zooms else []
    passes = [(scan, axes, 1), (scan, _other_rotations(), 1), *parts, *((scan, axes, zoom) for zoom in config.zooms)]
    for part, rotations, zoom in passes:
        best = _search(part, rotations, zoom, landmarker, config)
        if best is not None:
            return best
    raise BadInput(
        f"{scan_name(scan)}: no face found from any side; check that it shows a face, or crop it to the head"
    )


def _parts(scan: Scan) -> list[Scan]:
    """The connected pieces of a scan, largest first; none where it is of one piece."""
    piece = connected_parts(scan.mesh.faces, len(scan.mesh.vertices))
    of_face = piece[scan.mesh.faces[:, 0]]
    sizes = np.bincount(piece[np.unique(scan.mesh.faces)])
    large = [p for p in np.argsort(-sizes)[:MOST_PARTS] if sizes[p] >= LEAST_PART]
    if len(large) < 2:
        return []
    return [replace(scan, mesh=submesh(scan.mesh, of_face == p)[0]) for p in large]


def _search(
    scan: Scan, rotations: list[np.ndarray], zoom: int, landmarker: FaceLandmarker, config: LiftConfig
) -> Transform | None:
    """The face as seen from some directions, in tiles of pictures `zoom` times as large; None where there is none."""
    vertices = scan.mesh.vertices[np.unique(scan.mesh.faces)]
    centre = (vertices.min(0) + vertices.max(0)) / 2
    radius = float(np.linalg.norm(vertices - centre, axis=1).max())
    if not radius > 0:
        raise BadInput(f"{scan_name(scan)}: all vertices are in one point; give a scan of a face")
    sphere = Transform(np.eye(3), -centre / radius, 1 / radius)
    ball = replace(scan.mesh, vertices=sphere.apply(scan.mesh.vertices))
    renderer, caster = Renderer(ball, PLAIN, scan.texture), RayCaster(ball)
    found = [c for R in rotations for c in _candidates(renderer, caster, R, zoom, landmarker, config)]
    return _best(scan, sorted(found, key=lambda c: c.misfit), sphere, landmarker, config)


def _best(
    scan: Scan, found: list[_Candidate], sphere: Transform, landmarker: FaceLandmarker, config: LiftConfig
) -> Transform | None:
    """The candidate that stands a closer look, from where the face looks to."""
    best = None
    for candidate in found[:CANDIDATES]:
        start = candidate.T_face_scan @ sphere
        if best is not None and _apart(start, best) < config.apart:
            continue
        seen = look(scan, start, config.views[:1], landmarker, config)
        if seen is None or similarity_to_average(seen.points)[1] > config.max_misfit:
            continue
        apart = 0.0 if best is None else _apart(seen.T_face_scan, best)
        if apart > config.apart:
            raise BadInput(f"{scan_name(scan)}: two heads, {apart:.0f} mm apart; crop the scan to one of them")
        best = best or seen.T_face_scan
    return best


def scan_name(scan: Scan) -> str:
    """What messages call a scan."""
    return scan.name or "scan"


def _apart(T_face_scan: Transform, T_other_scan: Transform) -> float:
    """Distance between two faces' middles as the second measures it, mm."""
    middle = np.array([[0.0, -20.0, 90.0]])
    return float(np.linalg.norm((T_other_scan @ T_face_scan.inverse()).apply(middle) - middle))


def _candidates(
    renderer: Renderer,
    caster: RayCaster,
    rotation: np.ndarray,
    zoom: int,
    landmarker: FaceLandmarker,
    config: LiftConfig,
) -> list[_Candidate]:
    """Plausible faces in the four upright-and-turned pictures from one direction (unit ball at the origin)."""
    tile = config.sweep_pixels
    size = tile * zoom
    camera = Camera(FOCAL * size, FOCAL * size, (size - 1) / 2, (size - 1) / 2, size, size)
    view = View(camera, Transform(rotation, np.array([0.0, 0.0, AWAY])))
    found = []
    for corner, image in _tiles(renderer.draw(*view), tile):
        for turns in range(4):
            for seen in landmarker.detect_all(np.ascontiguousarray(np.rot90(image, turns))):
                if _tilt_deg(seen) > config.max_tilt_deg:
                    continue
                hits, points = lift_pixels(caster, view, _turned_back(seen.points, turns, tile) + corner)
                T_face_ball, misfit = similarity_to_average(points)
                if hits.hit.mean() > LEAST_HIT and misfit < 2 * config.max_misfit:
                    found.append(_Candidate(T_face_ball, misfit))
    return found


def _tiles(image: UInt8[np.ndarray, "h w 3"], size: int) -> Iterator[tuple[np.ndarray, UInt8[np.ndarray, "s s 3"]]]:
    """Square tiles that overlap by half and show something, each with its corner (u, v)."""
    for v in range(0, image.shape[0] - size + 1, size // 2):
        for u in range(0, image.shape[1] - size + 1, size // 2):
            part = image[v : v + size, u : u + size]
            if part.std() > BLANK:
                yield np.array([u, v]), part


def _turned_back(points: np.ndarray, turns: int, size: int) -> np.ndarray:
    """Pixels of an image that `np.rot90` turned, in the image before."""
    for _ in range(turns):
        points = np.stack([size - 1 - points[:, 1], points[:, 0]], 1)
    return points


def _tilt_deg(seen: Landmarks2D) -> float:
    """Angle between the face's up (chin to forehead) and the picture's."""
    up = seen.points[10] - seen.points[152]
    return float(np.degrees(np.abs(np.arctan2(up[0], -up[1]))))


def _axis_rotations() -> list[np.ndarray]:
    """Camera rotations that look along the six axes."""
    return [rotation_looking_along(np.array(axis, float)) for axis in (*np.eye(3), *-np.eye(3))]


def _other_rotations() -> list[np.ndarray]:
    """... along the twelve edges and eight corners of a cube."""
    ways = [np.array(w, float) for w in product((-1, 0, 1), repeat=3) if np.count_nonzero(w) >= 2]
    return [rotation_looking_along(w / np.linalg.norm(w)) for w in ways]
