"""Closest points on a surface."""

from dataclasses import dataclass

import igl
import numpy as np
from jaxtyping import Float, Int

from .mesh import Attachment, Mesh


@dataclass(frozen=True)
class Closest:
    """What `ClosestPoint.query` found, one row a query point."""

    distances: Float[np.ndarray, " q"]
    """Millimetres."""
    faces: Int[np.ndarray, " q"]
    points: Float[np.ndarray, "q 3"]
    barycentric: Float[np.ndarray, "q 3"]

    def attachment(self) -> Attachment:
        """The found points, fixed on the surface."""
        return Attachment(self.faces, self.barycentric)


class ClosestPoint:
    """An AABB tree over a mesh: build once, ask often."""

    def __init__(self, mesh: Mesh):
        self.mesh = mesh
        self._vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
        self._faces = np.ascontiguousarray(mesh.faces, dtype=np.int64)
        self._tree = igl.AABB()
        self._tree.init(self._vertices, self._faces)

    def query(self, points: Float[np.ndarray, "q 3"]) -> Closest:
        """The closest point on the surface to each of `points` (q, 3), millimetres."""
        answer = self._tree.squared_distance(self._vertices, self._faces, np.ascontiguousarray(points))
        squared, faces, found = (np.asarray(part) for part in answer)
        faces, found = faces.astype(np.int64), found.reshape(-1, 3)
        corners = self._vertices[self._faces[faces]]
        bary = barycentric(found, corners[:, 0], corners[:, 1], corners[:, 2])
        return Closest(np.sqrt(np.maximum(squared, 0)), faces, found, bary)


def closest_point(mesh: Mesh, points: Float[np.ndarray, "q 3"]) -> Closest:
    """One-shot `ClosestPoint(mesh).query(points)`."""
    return ClosestPoint(mesh).query(points)


def barycentric(
    points: Float[np.ndarray, "q 3"],
    a: Float[np.ndarray, "q 3"],
    b: Float[np.ndarray, "q 3"],
    c: Float[np.ndarray, "q 3"],
) -> Float[np.ndarray, "q 3"]:
    """Barycentric coordinates of points in the planes of triangles abc; they sum to 1 (thirds if degenerate)."""
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    wu, wv = (w * u).sum(1), (w * v).sum(1)
    determinant = uu * vv - uv * uv
    flat = determinant <= 1e-14 * np.maximum(uu * vv, 1e-300)
    safe = np.where(flat, 1.0, determinant)
    beta = np.where(flat, 1 / 3, (vv * wu - uv * wv) / safe)
    gamma = np.where(flat, 1 / 3, (uu * wv - uv * wu) / safe)
    return np.stack([1 - beta - gamma, beta, gamma], 1)
