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


def normal_equations(rows, right):
    """rows' rows (c, c) and rows' right (c,)."""
    return rows.T @ rows, rows.T @ right


def solve_factored(starts, indices, values, inverse, order, right):
    """Solve P' L D L' P x = right for the columns of `right` (n, 3)."""
    n = len(inverse)
    L = (sp.csc_matrix((values.astype(float), indices, starts.astype(int)), shape=(n, n)) + sp.identity(n)).tocsr()
    y = spsolve_triangular(L, right[order], lower=True) * inverse[:, None]
    out = np.empty_like(right)
    out[order] = spsolve_triangular(L.T.tocsr(), y, lower=False)
    return out


def plane_offsets(points, found, plane, weight, rotation):
    """From each vertex to the foot on its depth pixel's plane, in face space (n, 3); 0 where weight is 0."""
    gap = ((found - points) * plane).sum(1, keepdims=True)
    return np.where(weight[:, None] > 0, (gap * plane) @ rotation, 0)


def mean_square(share, displacement):
    """Sum of share (n,) times the squared length of displacement (n, 3)."""
    return share @ (displacement**2).sum(1)
