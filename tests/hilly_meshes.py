"""Hilly meshes, and all terms on one."""

import numpy as np

from mien.mesh import Attachment, Mesh, vertex_normals
from mien.register.residuals import laplacian_term, marker_term, membrane_term, plane_term, point_term
from mien.register.shape import make_stencil, turned_edges


def hills(n=25, size=100.0, shift=0.0, triangles="same"):
    """A patch with hills of side `size`, mm; `shift` moves the grid over the same hills."""
    u, v = np.meshgrid(np.linspace(-1, 1, n) + shift, np.linspace(-1, 1, n) + shift, indexing="ij")
    z = 0.25 * np.sin(3 * u + 0.5) * np.cos(2.5 * v) + 0.2 * u * v - 0.2 * u**2
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    halves = ((a, b, c), (a, c, d)) if triangles == "same" else ((a, b, d), (b, c, d))
    return Mesh(size / 2 * np.stack([u, v, z], -1).reshape(-1, 3), np.concatenate([np.stack(h, 1) for h in halves]))


def bent(points):
    """A smooth deformation of some millimetres."""
    x, y, _ = (points / 50).T
    return points + np.stack([2 * np.sin(2 * y), 2 * np.cos(1.5 * x), 4 * np.sin(2 * x + 1) * np.cos(2 * y)], 1)


MESH = hills()


def all_terms(x, mesh=MESH):
    stencil = make_stencil(mesh.vertices, mesh.faces)
    edges = turned_edges(stencil, mesh.vertices, None)
    rng = np.random.default_rng(1)
    weights = rng.random(len(x))
    at = Attachment(np.array([3, 19, 50]), np.array([[0.2, 0.3, 0.5]] * 3))
    return {
        "markers": marker_term(at.matrix(mesh), rng.normal(size=(3, 3)), np.array([1.0, 2, 3])),
        "laplacian": laplacian_term(stencil, edges, 1.0, 1.0),
        "membrane": membrane_term(stencil, edges, 0.1),
        "points": point_term(rng.normal(size=x.shape), weights),
        "planes": plane_term(rng.normal(size=x.shape), vertex_normals(mesh.vertices, mesh.faces), weights),
    }
