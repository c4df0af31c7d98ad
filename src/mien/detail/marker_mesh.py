"""The coarse triangle mesh over the markers, and where surface points lie in it (Ma et al. 2008, sec. 4.1)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int
from scipy.sparse.csgraph import dijkstra

from ..errors import BadInput
from ..mesh import Attachment, Mesh


@dataclass(frozen=True)
class MarkerMesh:
    """Triangles between markers along the surface: none goes across the mouth or an eye."""

    triangles: Int[np.ndarray, "m 3"]
    """Markers, counter-clockwise seen from outside."""
    nearest: Int[np.ndarray, " n"]
    """The marker nearest to each vertex of the surface, along the surface."""


@dataclass(frozen=True)
class Interpolation:
    """Where points lie in the coarse mesh: values at the markers, carried to the points."""

    corners: Int[np.ndarray, "p 3"]
    """Markers."""
    weights: Float[np.ndarray, "p 3"]
    triangle: Int[np.ndarray, " p"]
    """Which of the coarse mesh."""

    def of(self, values: Float[np.ndarray, "k *c"]) -> Float[np.ndarray, "p *c"]:
        """Values at the points."""
        return np.einsum("pc,pc...->p...", self.weights, values[self.corners])


def marker_mesh(mesh: Mesh, attachment: Attachment) -> MarkerMesh:
    """Triangulate the markers: the dual of their Voronoi cells along the surface's edges.

    Where three cells meet in a triangle of the surface, their markers are joined. Cells that a hole parts (the mouth,
    an eye) never meet, so nothing bridges it.

    A marker that meets no two others (on the rim of a lid, say) is in no triangle, and its cell goes to the others.

    Raises:
        BadInput: fewer than three markers that meet along the surface.
    """
    joined = np.arange(len(attachment.faces))
    while len(joined) >= 3:
        nearest = _nearest_marker(mesh, attachment, joined)
        triangles = _meeting(nearest[mesh.faces])
        found = np.unique(triangles)
        if len(found) == len(joined):
            return MarkerMesh(triangles, nearest)
        joined = found
    raise BadInput(
        f"marker mesh: {len(joined)} of {len(attachment.faces)} markers meet along the surface; at least 3 are needed"
    )


def _meeting(labels: Int[np.ndarray, "m 3"]) -> Int[np.ndarray, "t 3"]:
    """Triples of cells that meet in a triangle of the surface, each once."""
    meeting = (labels[:, 0] != labels[:, 1]) & (labels[:, 1] != labels[:, 2]) & (labels[:, 2] != labels[:, 0])
    meeting &= (labels >= 0).all(axis=1)
    found = labels[meeting]
    _, first = np.unique(np.sort(found, axis=1), axis=0, return_index=True)
    return found[np.sort(first)]


def _nearest_marker(mesh: Mesh, attachment: Attachment, among: Int[np.ndarray, " j"]) -> Int[np.ndarray, " n"]:
    """Multi-source shortest paths along edges, from the triangles of the markers `among`."""
    k, n = len(attachment.faces), len(mesh.vertices)
    i, j = mesh.faces[:, [0, 1, 2]].ravel(), mesh.faces[:, [1, 2, 0]].ravel()
    length = np.linalg.norm(mesh.vertices[i] - mesh.vertices[j], axis=1)
    corners = mesh.faces[attachment.faces]
    reach = np.linalg.norm(mesh.vertices[corners] - attachment.points(mesh)[:, None], axis=2)
    from_marker = np.repeat(np.arange(n, n + k), 3)
    rows, columns = np.r_[i, j, from_marker], np.r_[j, i, corners.ravel()]
    weights = np.maximum(np.r_[length, length, reach.ravel()], 1e-6)
    order = np.lexsort((weights, columns, rows))
    rows, columns, weights = rows[order], columns[order], weights[order]
    unique = np.r_[True, (np.diff(rows) != 0) | (np.diff(columns) != 0)]
    graph = sp.csr_matrix((weights[unique], (rows[unique], columns[unique])), shape=(n + k, n + k))
    _, _, sources = dijkstra(graph, indices=n + among, min_only=True, return_predecessors=True)
    return np.where(sources[:n] >= 0, sources[:n] - n, -1)


def interpolation(
    coarse: MarkerMesh,
    mesh: Mesh,
    attachment: Attachment,
    points: Attachment,
) -> Interpolation:
    """Barycentric places of surface points in the coarse mesh, found in the surface's texture coordinates.

    Only triangles at a point's own nearest marker are asked, so that lips do not see each other across the mouth.
    Beyond the outermost markers values are those of the nearest triangle's edge.

    Args:
        mesh: the surface, `with_texture`.
        attachment: the markers on it.
        points: the points on it.
    """
    assert mesh.uv is not None
    flat = np.einsum("pc,pcd->pd", points.barycentric, mesh.uv[mesh.faces[points.faces]])
    home = np.einsum("pc,pcd->pd", attachment.barycentric, mesh.uv[mesh.faces[attachment.faces]])
    biggest = points.barycentric.argmax(axis=1)
    label = coarse.nearest[mesh.faces[points.faces, biggest]]
    corners, weights = np.zeros((len(flat), 3), np.int64), np.zeros((len(flat), 3))
    best, inside = np.full(len(flat), np.inf), np.zeros(len(flat), np.int64)
    for marker in range(len(home)):
        mine = np.flatnonzero(label == marker)
        for number in np.flatnonzero((coarse.triangles == marker).any(axis=1)):
            triangle = coarse.triangles[number]
            bary, distance = _closest(flat[mine], home[triangle])
            closer = mine[distance < best[mine]]
            best[closer] = distance[distance < best[mine]]
            corners[closer], inside[closer] = triangle, number
            weights[closer] = bary[np.isin(mine, closer, assume_unique=True)]
    return Interpolation(corners, weights, inside)


def _closest(points: Float[np.ndarray, "p 2"], triangle: Float[np.ndarray, "3 2"]):
    """Barycentric coordinates of each point's nearest place on a triangle of the plane, and the distance."""
    edges = np.stack([triangle[1] - triangle[0], triangle[2] - triangle[0]], 1)
    determinant = np.linalg.det(edges)
    if abs(determinant) < 1e-18:
        return np.tile([1.0, 0.0, 0.0], (len(points), 1)), np.full(len(points), np.inf)
    inner = np.linalg.solve(edges, (points - triangle[0]).T).T
    bary = np.column_stack([1 - inner.sum(axis=1), inner])
    outside = (bary < 0).any(axis=1)
    distance = np.zeros(len(points))
    if outside.any():
        bary[outside], distance[outside] = _on_edges(points[outside], triangle)
    return bary, distance


def _on_edges(points: Float[np.ndarray, "p 2"], triangle: Float[np.ndarray, "3 2"]):
    """The same for points outside: the nearest of the three edges."""
    bary, best = np.zeros((len(points), 3)), np.full(len(points), np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        along = triangle[j] - triangle[i]
        share = np.clip((points - triangle[i]) @ along / max(along @ along, 1e-30), 0, 1)
        distance = np.linalg.norm(points - triangle[i] - share[:, None] * along, axis=1)
        closer = distance < best
        best[closer] = distance[closer]
        bary[closer] = 0
        bary[closer, i], bary[closer, j] = 1 - share[closer], share[closer]
    return bary, best
