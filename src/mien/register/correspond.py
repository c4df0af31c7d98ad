"""Closest-point correspondences, and which of them are not to be believed."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ..mesh import Attachment, ClosestPoint, Mesh, face_normals, vertex_normals


@dataclass(frozen=True)
class Rejection:
    """When a closest point is not believed."""

    max_distance: float = float("inf")
    """Millimetres; farther points are rejected. Infinity switches it off."""
    max_angle_deg: float = 60.0
    """Angle between the two normals, degrees; 180 switches it off."""
    boundary: bool = True
    """Reject points that fall on the rim of the target: what lies beyond the rim was not scanned."""


@dataclass(frozen=True)
class Correspondences:
    """Where each source point meets the target, one row a point."""

    points: Float[np.ndarray, "n 3"]
    """Closest points on the target, mm."""
    normals: Float[np.ndarray, "n 3"]
    """The target's unit normals there (interpolated over the triangle)."""
    distances: Float[np.ndarray, " n"]
    """Millimetres, never negative."""
    accepted: Bool[np.ndarray, " n"]
    """False where the point was rejected."""
    faces: Int[np.ndarray, " n"]
    """The target's triangle under each point."""
    barycentric: Float[np.ndarray, "n 3"]

    def attachment(self) -> Attachment:
        """The found points, fixed on the target."""
        return Attachment(self.faces, self.barycentric)

    def among(self, n: int, places: Int[np.ndarray, " k"]) -> "Correspondences":
        """The same as rows `places` of `n`; the other rows are rejected, their values zero."""

        def rows(values: np.ndarray) -> np.ndarray:
            out = np.zeros((n, *values.shape[1:]), values.dtype)
            out[places] = values
            return out

        parts = self.points, self.normals, self.distances, self.accepted, self.faces, self.barycentric
        return Correspondences(*(rows(part) for part in parts))


class Surface:
    """A target: its closest-point tree, its normals and its rim, worked out once."""

    def __init__(self, target: Mesh | ClosestPoint):
        self.tree = target if isinstance(target, ClosestPoint) else ClosestPoint(target)
        self.mesh = self.tree.mesh
        self._normals = vertex_normals(self.mesh.vertices, self.mesh.faces)
        self._face_normals = face_normals(self.mesh.vertices, self.mesh.faces)
        self._rim_edges, self._rim_vertices = _rim(self.mesh)

    def correspond(
        self,
        points: Float[np.ndarray, "n 3"],
        normals: Float[np.ndarray, "n 3"] | None = None,
        rejection: Rejection | None = None,
    ) -> Correspondences:
        """The closest point of the target to each of `points` (mm); without `normals` no angle is tested."""
        rule = rejection or Rejection()
        found = self.tree.query(points)
        corners = self.mesh.faces[found.faces]
        there = np.einsum("nc,ncd->nd", found.barycentric, self._normals[corners])
        length = np.linalg.norm(there, axis=1, keepdims=True)
        there = np.where(length > 1e-9, there / np.maximum(length, 1e-9), self._face_normals[found.faces])
        accepted = found.distances <= rule.max_distance
        if normals is not None and rule.max_angle_deg < 180:
            accepted &= np.einsum("nd,nd->n", normals, there) >= np.cos(np.radians(rule.max_angle_deg))
        if rule.boundary:
            accepted &= ~self._on_rim(found.faces, found.barycentric)
        return Correspondences(found.points, there, found.distances, accepted, found.faces, found.barycentric)

    def _on_rim(self, faces: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
        on_edge = (barycentric < 1e-5) & self._rim_edges[faces]
        on_corner = (barycentric > 1 - 1e-5) & self._rim_vertices[self.mesh.faces[faces]]
        return np.any(on_edge | on_corner, axis=1)


def _rim(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Which edges (m, 3), each named by the corner across from it, and which vertices (n,) lie on the mesh's rim."""
    across = np.sort(mesh.faces[:, [[1, 2], [2, 0], [0, 1]]], axis=2).reshape(-1, 2)
    keys = across[:, 0].astype(np.int64) * len(mesh.vertices) + across[:, 1]
    _, edge, count = np.unique(keys, return_inverse=True, return_counts=True)
    edges = (count == 1)[edge]
    vertices = np.zeros(len(mesh.vertices), bool)
    vertices[across[edges]] = True
    return edges.reshape(-1, 3), vertices
