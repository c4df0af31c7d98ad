"""Loop's smooth subdivision: as matrices for any vertex values, and of whole meshes."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from .mesh import Mesh
from .operators import adjacency, edge_ends


@dataclass(frozen=True)
class Refinement:
    """One round of Loop's subdivision as a matrix: old vertices first, triangle f becomes triangles 4 f .. 4 f + 3."""

    matrix: sp.csr_matrix
    """(n + edges, n): new vertices from old ones."""
    between: sp.csr_matrix
    """(n + edges, n): values on vertices carried over, straight along edges, so that nothing blurs."""
    faces: Int[np.ndarray, "m4 3"]

    @staticmethod
    def corners(values: Float[np.ndarray, "m 3 c"]) -> Float[np.ndarray, "m4 3 c"]:
        """Values on the triangles' corners (texture coordinates) carried over, straight along edges."""
        a, b, c = values[:, 0], values[:, 1], values[:, 2]
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        return np.stack([np.stack(part, 1) for part in parts], 1).reshape(-1, 3, values.shape[2])


def loop_subdivide(mesh: Mesh, times: int = 1) -> tuple[Mesh, sp.csr_matrix]:
    """The mesh with four triangles for each, smoothed by Loop's rules, and S (new, old): S @ vertices are its vertices.

    Old vertices stay first. S serves any vertex values, such as blendshapes. Texture coordinates and colours go to
    edge middles, unsmoothed, so that seams stay where they are.
    """
    S = sp.csr_matrix(sp.identity(len(mesh.vertices)))
    for _ in range(times):
        step = loop_refinement(mesh.faces, len(mesh.vertices))
        mesh, S = subdivided(mesh, step), sp.csr_matrix(step.matrix @ S)
    return mesh, S


def subdivided(mesh: Mesh, step: Refinement) -> Mesh:
    """The mesh after one round whose matrices are known already; see `loop_subdivide`."""
    uv, uv_faces = mesh.uv, mesh.uv_faces
    if uv is not None and uv_faces is None:
        uv = step.between @ uv
    elif uv is not None and uv_faces is not None:
        seams = loop_refinement(uv_faces, len(uv))
        uv, uv_faces = seams.between @ uv, seams.faces
    colors = None if mesh.colors is None else step.between @ mesh.colors
    return Mesh(step.matrix @ mesh.vertices, step.faces, uv, uv_faces, colors)


def loop_refinement(faces: Int[np.ndarray, "m 3"], n: int) -> Refinement:
    """Loop's subdivision (Loop 1987, with Warren's weights) of `n` vertices; open edges stay open and smooth.

    An edge of more than two triangles counts as open, a vertex where open edges do not pass straight through stays.
    """
    edges, of_corner, count = np.unique(edge_ends(faces), axis=0, return_inverse=True, return_counts=True)
    of_corner = of_corner.reshape(-1, 3)
    inner = count == 2
    matrix = sp.vstack([_kept(faces, edges[~inner], n), _split(faces, edges, of_corner, inner, n)])
    between = sp.vstack([sp.identity(n), _split(faces, edges, of_corner, np.zeros_like(inner), n)])
    ab, bc, ca = (of_corner + n).T
    a, b, c = faces.T
    parts = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
    finer = np.stack([np.stack(part, 1) for part in parts], 1).reshape(-1, 3)
    return Refinement(sp.csr_matrix(matrix), sp.csr_matrix(between), finer)


def _split(faces, edges, of_corner, inner, n: int) -> sp.csr_matrix:
    """New vertices on the edges: 3/8 of each end and 1/8 of each corner across; the middle of an open edge."""
    rows = np.arange(len(edges))
    share = np.where(inner, 3 / 8, 1 / 2)
    ends = sp.csr_matrix((np.r_[share, share], (np.r_[rows, rows], edges.T.ravel())), shape=(len(edges), n))
    across, edge = faces[:, [2, 0, 1]].ravel(), of_corner.ravel()
    return ends + sp.csr_matrix((inner[edge] / 8, (edge, across)), shape=(len(edges), n))


def _kept(faces, open_edges, n: int) -> sp.csr_matrix:
    """Old vertices moved towards their neighbours, along the open edge where they lie on one."""
    A = adjacency(faces, n)
    degree = np.asarray(A.sum(axis=1)).ravel()
    beta = np.where(degree == 3, 3 / 16, 3 / (8 * np.maximum(degree, 1)))
    i, j = np.r_[open_edges, open_edges[:, ::-1]].T
    border = sp.csr_matrix((np.ones(len(i)), (i, j)), shape=(n, n))
    borders = np.asarray(border.sum(axis=1)).ravel()
    inner = (borders == 0) & (degree > 0)
    through = borders == 2
    stays = np.where(inner, 1 - degree * beta, np.where(through, 3 / 4, 1.0))
    return sp.diags(stays) + sp.diags(np.where(inner, beta, 0)) @ A + sp.diags(np.where(through, 1 / 8, 0)) @ border
