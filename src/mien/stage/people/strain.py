"""How much skin is compressed along a direction, from the coarse surface alone."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from ...mesh import Mesh, adjacency, face_areas, face_normals


@dataclass(frozen=True)
class StrainGauge:
    """Compression along one direction, on the vertices of a coarse mesh, for any deformed shape of it."""

    faces: Int[np.ndarray, "f 3"]
    """The triangles that are measured."""
    along: Float[np.ndarray, "f 2"]
    """For each triangle (p, q) with p e1 + q e2 the unit direction on the resting surface, e1 and e2 its edges."""
    carry: sp.csr_matrix
    """(n, f): triangles to vertices, averaged and smoothed."""

    def compression(self, vertices: Float[np.ndarray, "frames n 3"]) -> Float[np.ndarray, "frames n"]:
        """1 minus the stretch along the direction; 0.1 where skin is 10 % shorter, negative where it is longer."""
        a, b, c = (vertices[:, self.faces[:, i]] for i in range(3))
        now = self.along[:, :1] * (b - a) + self.along[:, 1:] * (c - a)
        return (self.carry @ (1.0 - np.linalg.norm(now, axis=2)).T).T


def strain_gauge(
    mesh: Mesh, used: Int[np.ndarray, " f"], directions: Float[np.ndarray, "f 3"], smoothing: int = 2
) -> StrainGauge:
    """A gauge on the triangles `used` of a resting mesh; `directions` are projected onto each triangle.

    Args:
        smoothing: rounds of averaging with neighbours, 0 for none.
    """
    faces = mesh.faces[used]
    normals = face_normals(mesh.vertices, faces)
    d = directions - (directions * normals).sum(axis=1, keepdims=True) * normals
    d /= np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-9)
    a, b, c = (mesh.vertices[faces[:, i]] for i in range(3))
    e1, e2 = b - a, c - a
    g11, g12, g22 = (e1 * e1).sum(1), (e1 * e2).sum(1), (e2 * e2).sum(1)
    d1, d2 = (d * e1).sum(1), (d * e2).sum(1)
    det = np.maximum(g11 * g22 - g12**2, 1e-12)
    along = np.stack([g22 * d1 - g12 * d2, g11 * d2 - g12 * d1], axis=1) / det[:, None]
    return StrainGauge(faces, along, _carry(mesh, faces, smoothing))


def _carry(mesh: Mesh, faces: np.ndarray, smoothing: int) -> sp.csr_matrix:
    n, f = len(mesh.vertices), len(faces)
    area = face_areas(mesh.vertices, faces)
    entries, columns = np.repeat(area, 3), np.repeat(np.arange(f), 3)
    sums = sp.csr_matrix((entries, (faces.ravel(), columns)), shape=(n, f))
    A = adjacency(faces, n) + sp.identity(n)
    for _ in range(smoothing):
        sums = A @ sums
    total = np.asarray(sums.sum(axis=1)).ravel()
    return sp.csr_matrix(sp.diags(1.0 / np.where(total > 0, total, 1.0)) @ sums)
