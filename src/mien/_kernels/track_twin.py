"""Numpy twins of `track`."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve_triangular
from scipy.spatial.transform import Rotation


def vertex_normals(vertices, faces):
    """Unit, area-weighted (n, 3) of a mesh; zero for a vertex of no triangle."""
    a, b, c = (vertices[faces[:, i]].astype(float) for i in range(3))
    out = np.zeros(vertices.shape)
    np.add.at(out, faces.ravel(), np.repeat(np.cross(b - a, c - a), 3, axis=0))
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return out / np.where(length == 0, 1, length)


def place(vertices, rotation, translation):
    """rotation @ v + translation for every row (n, 3)."""
    return vertices @ rotation.T + translation


def turned(rotation, translation, motion, centre):
    """A pose followed by a turn motion[:3] (radians) about `centre` and a shift motion[3:]: rotation, translation."""
    turn = Rotation.from_rotvec(motion[:3]).as_matrix()
    return turn @ rotation, turn @ (translation - centre) + centre + motion[3:]


def plane_rows(basis, rotation, points, found, plane, weight, centre, scale):
    """Rows of the point-to-plane term (Li et al. 2013, eq. 1) and of a small turn and shift: rows, right-hand side."""
    keep = weight > 0
    n, p = plane[keep].astype(float), points[keep].astype(float)
    r = (n * (found[keep] - p)).sum(1)
    root = np.sqrt(weight[keep]) / (1 + (r / scale) ** 2)
    shapes = np.einsum("id,idk->ik", n @ rotation, basis[keep])
    return root[:, None] * np.concatenate([shapes, np.cross(p - centre, n), n], 1), root * r


def normal_equations(rows, right):
    """rows' rows (c, c) and rows' right (c,)."""
    return rows.T @ rows, rows.T @ right


def solve_factored(starts, indices, values, pivots, order, right):
    """Solve P' L D L' P x = right for the columns of `right` (n, 3)."""
    n = len(pivots)
    L = (sp.csc_matrix((values, indices, starts), shape=(n, n)) + sp.identity(n)).tocsr()
    y = spsolve_triangular(L, right[order], lower=True) / pivots[:, None]
    out = np.empty_like(right)
    out[order] = spsolve_triangular(L.T.tocsr(), y, lower=False)
    return out
