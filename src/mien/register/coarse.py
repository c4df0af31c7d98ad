"""A decimated template for stiff rounds, and the way there and back, along the surface and never across a gap."""

from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from ..errors import BadInput
from ..mesh import Attachment, Mesh, barycentric, nearest_along_edges
from .residuals import Stencil
from .shape import local_rotations, make_stencil


class CoarseTemplate:
    """A template with fewer vertices. Lips that touch stay apart: nearness is measured along the surface.

    Raises:
        BadInput: a mesh that cannot be decimated: edges of more than two triangles, or neighbours wound differently.
    """

    def __init__(self, fine: Mesh, vertices: int):
        self._fine = fine
        corners, triangles, birth = _decimated(fine, vertices)
        kept = _nearest_members(fine, _cells(fine, birth), birth, corners)
        self.mesh = Mesh(fine.vertices[kept], triangles)
        self.stencil: Stencil = make_stencil(self.mesh.vertices, self.mesh.faces)
        self._cell = _cells(fine, kept)
        self._fans = _fans(self.mesh)
        self._mean = _means(self._cell, len(corners))
        self._home = self._beside(fine.vertices, self._cell)

    @cached_property
    def prolongation(self) -> sp.csr_matrix:
        """(n, k): fine displacements from coarse ones, straight over each coarse triangle."""
        return self._home.matrix(self.mesh)

    def averaged(self, values: Float[np.ndarray, "n *c"]) -> np.ndarray:
        """Values of fine vertices, averaged over those that each coarse vertex stands for."""
        return self._mean @ values

    def attachment(self, on_fine: Attachment) -> Attachment:
        """Points on the fine template as points on this one."""
        heaviest = on_fine.barycentric.argmax(axis=1)
        corner = self._fine.faces[on_fine.faces, heaviest]
        return self._beside(on_fine.points(self._fine), self._cell[corner])

    def down(self, x: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "k 3"]:
        """The coarse vertices when the fine ones are at `x`: each has moved as those around it have."""
        return self.mesh.vertices + self._mean @ (x - self._fine.vertices)

    def up(self, y: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "n 3"]:
        """The fine vertices when the coarse ones are at `y`: each rides on its triangle, offset and turn included."""
        turns = local_rotations(self.stencil, self.mesh.vertices, y)
        corners = self.mesh.faces[self._home.faces]
        offsets = self._fine.vertices[:, None] - self.mesh.vertices[corners]
        carried = y[corners] + np.einsum("ncab,ncb->nca", turns[corners], offsets)
        return np.einsum("nc,ncd->nd", self._home.barycentric, carried)

    def _beside(self, points: Float[np.ndarray, "p 3"], cells: Int[np.ndarray, " p"]) -> Attachment:
        """The closest point to each of `points` on the triangles round its coarse vertex."""
        nearest = np.full(len(points), np.inf)
        faces, weights = np.zeros(len(points), np.int64), np.zeros((len(points), 3))
        walking = np.arange(len(points))
        for _ in range(3):
            before = nearest[walking].copy()
            for fan in self._fans[cells[walking]].T:
                a, b, c = (self.mesh.vertices[self.mesh.faces[fan, k]] for k in range(3))
                inside = _clamped(points[walking], a, b, c)
                there = inside[:, :1] * a + inside[:, 1:2] * b + inside[:, 2:] * c
                squared = ((there - points[walking]) ** 2).sum(axis=1)
                better = squared < nearest[walking]
                who = walking[better]
                nearest[who], faces[who], weights[who] = squared[better], fan[better], inside[better]
            walking = walking[nearest[walking] < before]
            cells = cells.copy()
            cells[walking] = self.mesh.faces[faces[walking], weights[walking].argmax(axis=1)]
        return Attachment(faces, weights)


def _decimated(fine: Mesh, vertices: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (k, 3) and triangles of the decimated mesh, and the fine vertex that each began as."""
    directed = fine.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)
    keys = directed[:, 0] * len(fine.vertices) + directed[:, 1]
    corners, triangles, birth = np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    if len(np.unique(keys)) == len(keys):
        faces = np.ascontiguousarray(fine.faces, dtype=np.int64)
        made = igl.decimate(np.ascontiguousarray(fine.vertices), faces, 2 * vertices)
        corners, triangles, _, birth = (np.asarray(part) for part in made)
    if not len(corners):
        raise BadInput("template: edges of more than two triangles or mixed winding; mend it, or use another template")
    return corners, triangles.astype(np.int64), birth.astype(np.int64)


def _cells(fine: Mesh, seeds: Int[np.ndarray, " k"]) -> Int[np.ndarray, " n"]:
    """Which of the `seeds` (fine vertices) is the nearest to each fine vertex along the edges; 0 where none is."""
    source, _ = nearest_along_edges(fine, seeds)
    number = np.zeros(len(fine.vertices), np.int64)
    number[seeds] = np.arange(len(seeds))
    return np.where(source >= 0, number[source], 0)


def _nearest_members(fine: Mesh, cell: np.ndarray, seeds: np.ndarray, places: np.ndarray) -> Int[np.ndarray, " k"]:
    """Of each cell the fine vertex that is nearest to the place (k, 3) that decimation chose."""
    off = ((fine.vertices - places[cell]) ** 2).sum(axis=1)
    order = np.lexsort((off, cell))
    first = np.r_[True, np.diff(cell[order]) > 0]
    kept = seeds.copy()
    kept[cell[order[first]]] = order[first]
    return kept


def _means(cell: Int[np.ndarray, " n"], k: int) -> sp.csr_matrix:
    """(k, n): averages over cells."""
    share = 1 / np.maximum(np.bincount(cell, minlength=k), 1)
    return sp.csr_matrix((share[cell], (cell, np.arange(len(cell)))), shape=(k, len(cell)))


def _fans(mesh: Mesh) -> Int[np.ndarray, "k f"]:
    """The triangles round each vertex, the first of them repeated until all rows are as long."""
    order = np.argsort(mesh.faces.ravel(), kind="stable")
    count = np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices))
    start = np.cumsum(count) - count
    step = np.arange(count.max())
    place = start[:, None] + np.where(step < count[:, None], step, 0)
    return (order // 3)[np.minimum(place, len(order) - 1)]


def _clamped(points: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Barycentric coordinates of the closest points of the triangles abc: in the plane, else on the nearest edge."""
    weights = barycentric(points, a, b, c)
    outside = np.flatnonzero((weights < 0).any(axis=1))
    if not len(outside):
        return weights
    p, corners = points[outside], np.stack([a[outside], b[outside], c[outside]], 1)
    best, nearest = np.zeros((len(p), 3)), np.full(len(p), np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        along = corners[:, j] - corners[:, i]
        share = np.einsum("nd,nd->n", p - corners[:, i], along) / np.maximum((along**2).sum(axis=1), 1e-300)
        share = np.clip(share, 0, 1)
        squared = ((p - corners[:, i] - share[:, None] * along) ** 2).sum(axis=1)
        better = squared < nearest
        nearest[better] = squared[better]
        best[better] = 0
        best[better, i], best[better, j] = 1 - share[better], share[better]
    weights[outside] = best
    return weights
