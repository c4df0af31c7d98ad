"""Discrete differential operators of a triangle mesh, on plain arrays."""

import igl
import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int
from scipy.sparse.csgraph import connected_components


def cotangent_laplacian(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> sp.csc_matrix:
    """Cotangent Laplacian (n, n), positive semidefinite, unit-free: `x @ L @ x` is the Dirichlet energy of x.

    Off-diagonal entries are -(cot a + cot b) / 2 (Botsch and Sorkine 2008). Degenerate triangles count for nothing.
    """
    L = -igl.cotmatrix(vertices, faces.astype(np.int64)).tocsc()
    L.data = np.nan_to_num(L.data, nan=0.0, posinf=0.0, neginf=0.0)
    return L


def uniform_laplacian(faces: Int[np.ndarray, "m 3"], n: int) -> sp.csc_matrix:
    """Graph Laplacian (n, n): degree minus adjacency. Depends on the connections alone."""
    A = adjacency(faces, n)
    return (sp.diags(np.asarray(A.sum(axis=1)).ravel()) - A).tocsc()


def mass(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> Float[np.ndarray, " n"]:
    """Area that belongs to each vertex, mm^2: a third of every triangle around it. Sums up to the surface's area."""
    areas = face_areas(vertices, faces)
    return np.bincount(faces.ravel(), np.repeat(areas / 3, 3), minlength=len(vertices))


def face_areas(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> Float[np.ndarray, " m"]:
    """Triangle areas, mm^2."""
    return np.linalg.norm(_face_crosses(vertices, faces), axis=1) / 2


def face_normals(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> Float[np.ndarray, "m 3"]:
    """Unit normals of the triangles; zero for a degenerate one."""
    return _unit(_face_crosses(vertices, faces))


def grid_faces(points: Float[np.ndarray, "h w 3"], longest: float) -> Int[np.ndarray, "m 3"]:
    """Neighbours of a grid joined by triangles, as indices into its points row by row; none with a longer edge.

    A triangle whose corner is NaN is none.
    """
    number = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]
    faces = np.concatenate([np.stack(corners, -1).reshape(-1, 3) for corners in ((a, b, c), (c, b, d))])
    corners = points.reshape(-1, 3)[faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return faces[(np.nan_to_num(sides, nan=np.inf) < longest).all(axis=1)]


def vertex_normals(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> Float[np.ndarray, "n 3"]:
    """Unit vertex normals, area-weighted; zero for a vertex of no triangle."""
    crosses = _face_crosses(vertices, faces)
    flat = faces.ravel()
    n = len(vertices)
    return _unit(np.stack([np.bincount(flat, np.repeat(crosses[:, d], 3), minlength=n) for d in range(3)], 1))


def adjacency(faces: Int[np.ndarray, "m 3"], n: int) -> sp.csr_matrix:
    """Which vertices share an edge: symmetric 0/1 matrix (n, n)."""
    i = faces[:, [0, 1, 2]].ravel()
    j = faces[:, [1, 2, 0]].ravel()
    A = sp.csr_matrix((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), shape=(n, n))
    A.data[:] = 1.0
    return A


def connected_parts(faces: Int[np.ndarray, "m 3"], n: int) -> Int[np.ndarray, " n"]:
    """Which connected part each of n vertices is of, from 0; a vertex of no triangle is a part of its own."""
    return connected_components(adjacency(faces, n), directed=False)[1]


def in_largest_part(faces: Int[np.ndarray, "m 3"], n: int) -> Bool[np.ndarray, " m"]:
    """Whether each triangle is of the connected part of the most triangles."""
    of_face = connected_parts(faces, n)[faces[:, 0]]
    return of_face == np.bincount(of_face).argmax()


def edge_ends(faces: Int[np.ndarray, "m 3"]) -> Int[np.ndarray, "m3 2"]:
    """The three edges of each triangle, the smaller vertex first; one that two triangles share stands there twice."""
    return np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)


def boundary_vertices(faces: Int[np.ndarray, "m 3"]) -> Int[np.ndarray, " b"]:
    """Vertices on an edge of one triangle alone, in increasing order."""
    unique, count = np.unique(edge_ends(faces), axis=0, return_counts=True)
    return np.unique(unique[count == 1])


def mean_edge_length(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> float:
    """Mean length of a triangle side, mm."""
    corners = vertices[faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())


def _face_crosses(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length == 0, 1.0, length)
