"""Half a face made whole for the detector: what was cut along the middle is mirrored there."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..mesh import Mesh, Scan, boundary_vertices

TRIES = 300
"""Planes through three points of the rim that are tried."""
FLAT = 0.012
"""The rim lies in the plane to this share of the scan's size."""
LEAST_RIM = 0.2
"""At least this share of the rim's vertices lies in the plane."""
ONE_SIDE = 0.97
"""At least this share of the scan lies on one side of it."""
SLACK = 0.03
"""... or no farther beyond than this share of the scan's size."""


@dataclass(frozen=True)
class Plane:
    """normal . x = offset; the scan lies where normal . x is larger."""

    normal: Float[np.ndarray, " 3"]
    offset: float

    def height(self, points: Float[np.ndarray, "p 3"]) -> Float[np.ndarray, " p"]:
        """Signed distance from the plane, positive where the scan is."""
        return points @ self.normal - self.offset

    def mirrored(self, points: Float[np.ndarray, "p 3"]) -> Float[np.ndarray, "p 3"]:
        """Points on the other side."""
        return points - 2 * self.height(points)[:, None] * self.normal


def cut_planes(mesh: Mesh, most: int = 3) -> list[Plane]:
    """Planes in which a good part of the rim lies and beyond which is no scan; the fullest first, all distinct."""
    rim = mesh.vertices[boundary_vertices(mesh.faces)]
    if len(rim) < 3:
        return []
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    rng = np.random.default_rng(0)
    found: list[tuple[int, Plane]] = []
    for _ in range(TRIES):
        plane = _through(rim[rng.choice(len(rim), 3, replace=False)], mesh.vertices)
        if plane is None:
            continue
        inside = np.abs(plane.height(rim)) < FLAT * size
        beyond = (plane.height(mesh.vertices) > -SLACK * size).mean()
        if inside.mean() > LEAST_RIM and beyond > ONE_SIDE:
            found.append((int(inside.sum()), _refitted(rim[inside], plane)))
    distinct: list[Plane] = []
    for _, plane in sorted(found, key=lambda pair: -pair[0]):
        if all(abs(plane.normal @ other.normal) < 0.9 for other in distinct):
            distinct.append(plane)
    return distinct[:most]


def completed(scan: Scan, plane: Plane) -> Scan:
    """The scan and its mirror image; vertices of the scan come first."""
    m, n = scan.mesh, len(scan.mesh.vertices)
    vertices = np.concatenate([m.vertices, plane.mirrored(m.vertices)])
    faces = np.concatenate([m.faces, m.faces[:, ::-1] + n])
    colors = None if m.colors is None else np.concatenate([m.colors, m.colors])
    if m.uv is None or m.uv_faces is None:
        uv = None if m.uv is None else np.concatenate([m.uv, m.uv])
        return replace(scan, mesh=Mesh(vertices, faces, uv, None, colors))
    uv_faces = np.concatenate([m.uv_faces, m.uv_faces[:, ::-1]])
    return replace(scan, mesh=Mesh(vertices, faces, m.uv, uv_faces, colors))


def _through(three: Float[np.ndarray, "3 3"], vertices: np.ndarray) -> Plane | None:
    """The plane through three points, the scan's larger part above it; None for points on a line."""
    normal = np.cross(three[1] - three[0], three[2] - three[0])
    length = float(np.linalg.norm(normal))
    if not length > 1e-12 * float(np.ptp(vertices)) ** 2:
        return None
    normal = normal / length
    offset = float(normal @ three[0])
    above = np.median(vertices @ normal) > offset
    return Plane(normal, offset) if above else Plane(-normal, -offset)


def _refitted(points: Float[np.ndarray, "p 3"], plane: Plane) -> Plane:
    """The plane in least squares."""
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre, full_matrices=False)[2][2]
    normal = normal if normal @ plane.normal > 0 else -normal
    return Plane(normal, float(normal @ centre))
