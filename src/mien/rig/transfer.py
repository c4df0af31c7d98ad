"""Deformation transfer (Sumner and Popovic 2004): one face's expressions on another face, of any topology.

Every source triangle's deformation gradient S (3 x 3, with the normal as third direction) is asked of the target
triangles that correspond to it: min over x' of sum_t area_t |grad x' - S_t grad x|^2. Sumner and Popovic write it with
a fourth vertex a triangle; that vertex is in one triangle alone, and without it the problem is the Poisson system of
Botsch et al. 2006, cotangent Laplacian at the left and therefore factorised once for all expressions. Where source and
target are the same surface the answer is exact. A part that turns rigidly in the source (eyeball, teeth) has one S, and
so turns rigidly in the target.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int
from scipy.sparse.linalg import splu

from ..mesh import ClosestPoint, Mesh, connected_parts, face_areas, face_normals
from .facs import FACS23
from .rig import Rig

STILL = 1e-6
"""Millimetres: a source triangle that never moves more is still, and so is what corresponds to it."""


@dataclass(frozen=True)
class _Part:
    """A connected part of the target."""

    vertices: Int[np.ndarray, " v"]
    faces: Int[np.ndarray, " f"]
    floats: bool
    """No vertex of it is held: its place comes from the source's mean displacement."""


class DeformationTransfer:
    """Factorise once, transfer any number of deformed sources."""

    def __init__(
        self,
        source: Mesh,
        target: Mesh,
        correspondence: Int[np.ndarray, " target_faces"] | None = None,
        held: Int[np.ndarray, " held"] | None = None,
    ):
        """
        Args:
            source, target: both in rest, in the same orientation; millimetres.
            correspondence: for each target triangle the source triangle that rules it; None where the two have the
                same triangles.
            held: target vertices that no expression moves.

        Raises:
            ValueError: no correspondence given, and the triangles differ in number.
        """
        if correspondence is None:
            if len(source.faces) != len(target.faces):
                raise ValueError(
                    f"correspondence: needed, since the source has {len(source.faces)} triangles "
                    f"and the target {len(target.faces)}"
                )
            correspondence = np.arange(len(target.faces))
        self.source, self.target, self.correspondence = source, target, correspondence
        self._frames = np.linalg.inv(_frames(source.vertices, source.faces))
        self._area = face_areas(target.vertices, target.faces)
        self._divergence, self._edges = _operators(target)
        self._scale = _size_ratio(source, target, correspondence)
        held = np.zeros(0, int) if held is None else held
        self._parts = _parts(target, held)
        self._held = np.union1d(held, [part.vertices[0] for part in self._parts if part.floats]).astype(int)
        self._free = np.setdiff1d(np.arange(len(target.vertices)), self._held)
        L = sp.csc_matrix(self._divergence @ self._edges)
        options = {"SymmetricMode": True}
        self._solve = splu(L[self._free][:, self._free], permc_spec="MMD_AT_PLUS_A", options=options).solve
        self._coupling = L[self._free][:, self._held]

    def displacements(self, deformed: Float[np.ndarray, "source_n 3"]) -> Float[np.ndarray, "target_n 3"]:
        """How the target's vertices move when the source takes the shape `deformed` (mm)."""
        rest = self.target.vertices
        S = _frames(deformed, self.source.faces) @ self._frames
        wanted = np.einsum("tij,tcj->tci", S[self.correspondence], (self._edges @ rest).reshape(-1, 3, 3))
        right = (self._divergence @ wanted.reshape(-1, 3))[self._free] - self._coupling @ rest[self._held]
        moved = np.zeros_like(rest)
        moved[self._free] = self._solve(right) - rest[self._free]
        moves = (deformed - self.source.vertices)[self.source.faces].mean(1)[self.correspondence] * self._scale
        for part in self._parts:
            if part.floats:
                moved[part.vertices] += self._mean(moves, part) - self._mean(moved[self.target.faces].mean(1), part)
        return moved

    def _mean(self, moves: np.ndarray, part: _Part) -> np.ndarray:
        return np.average(moves[part.faces], axis=0, weights=self._area[part.faces])


def nearest_faces(source: Mesh, target: Mesh) -> Int[np.ndarray, " target_faces"]:
    """A correspondence for surfaces that lie on one another: the source triangle nearest to each target triangle.

    Triangles that face another way (an inner lip beside an outer one) are passed over where one that faces the same
    way is within reach: the centroid is asked again from a little outside, along its normal.
    """
    tree = ClosestPoint(source)
    centres, out = target.vertices[target.faces].mean(1), face_normals(target.vertices, target.faces)
    normals = face_normals(source.vertices, source.faces)
    found = tree.query(centres)
    best, agree = found.faces.copy(), (normals[found.faces] * out).sum(1)
    for step in (0.5, 1.0, 2.0, 4.0):
        wrong = agree < 0.2
        if not wrong.any():
            break
        again = tree.query(centres[wrong] + step * out[wrong]).faces
        better = (normals[again] * out[wrong]).sum(1)
        improves = better > agree[wrong]
        which = np.flatnonzero(wrong)[improves]
        best[which], agree[which] = again[improves], better[improves]
    return best


def transfer_deltas(
    source: Mesh,
    deltas: Float[np.ndarray, "shapes source_n 3"],
    target: Mesh,
    correspondence: Int[np.ndarray, " target_faces"] | None = None,
) -> Float[np.ndarray, "shapes target_n 3"]:
    """Displacements of `source`, one shape a row, on `target` (mm). What never moves in the source is held."""
    identity = np.arange(len(target.faces)) if correspondence is None else correspondence
    held = _still(source, deltas, target, identity)
    transfer = DeformationTransfer(source, target, correspondence, held=held)
    return np.stack([transfer.displacements(source.vertices + delta) for delta in deltas])


def transfer_rig(rig: Rig, target: Mesh, correspondence: Int[np.ndarray, " target_faces"] | None = None) -> Rig:
    """All of a rig's expressions on another person (Li et al. 2013, sec. 3): same names, the target as neutral.

    The texture goes along where the two have the same triangles; else there is none.
    """
    deltas = transfer_deltas(rig.neutral, rig.deltas, target, correspondence)
    return Rig(target, deltas, rig.names, rig.texture if correspondence is None else None)


def _frames(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Columns e1, e2, n / sqrt|n| of every triangle (m, 3, 3); a flat triangle keeps an invertible stand-in."""
    corners = vertices[faces]
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(e1, e2)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    frames = np.stack([e1, e2, normal / np.sqrt(np.maximum(length, 1e-12))], -1)
    frames[length[:, 0] < 1e-9] = np.eye(3)
    return frames


def _operators(mesh: Mesh) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Cotangent-weighted divergence (n, 3m) and edge differences (3m, n); their product is the Laplacian."""
    n, m = len(mesh.vertices), len(mesh.faces)
    i, j = mesh.faces[:, [1, 2, 0]].ravel(), mesh.faces[:, [2, 0, 1]].ravel()
    a, b = (mesh.vertices[v] - mesh.vertices[mesh.faces].reshape(-1, 3) for v in (i, j))
    double_area = np.linalg.norm(np.cross(a, b), axis=1)
    cot = np.clip((a * b).sum(1) / np.maximum(double_area, 1e-12), -100, 100) / 2
    rows = np.arange(3 * m)
    edges = sp.csr_matrix((np.r_[np.ones(3 * m), -np.ones(3 * m)], (np.r_[rows, rows], np.r_[i, j])), shape=(3 * m, n))
    return (edges.T @ sp.diags(cot)).tocsr(), edges


def _size_ratio(source: Mesh, target: Mesh, correspondence: np.ndarray) -> float:
    """How much larger the target is than the part of the source that rules it, a length ratio."""
    covered = face_areas(source.vertices, source.faces)[np.unique(correspondence)].sum()
    return float(np.sqrt(face_areas(target.vertices, target.faces).sum() / covered))


def _parts(target: Mesh, held: np.ndarray) -> list[_Part]:
    label = connected_parts(target.faces, len(target.vertices))
    is_held = np.zeros(len(target.vertices), bool)
    is_held[held] = True
    vertex_order, face_label = np.argsort(label, kind="stable"), label[target.faces[:, 0]]
    groups = np.split(vertex_order, np.cumsum(np.bincount(label))[:-1])
    parts = []
    for k, vertices in enumerate(groups):
        faces = np.flatnonzero(face_label == k)
        if len(faces):
            parts.append(_Part(vertices, faces, not bool(is_held[vertices].any())))
    return parts


def _still(source: Mesh, deltas: np.ndarray, target: Mesh, correspondence: np.ndarray) -> np.ndarray:
    """Target vertices that no shape moves: every triangle round them is ruled by one that never moves; strays too."""
    moves = np.abs(deltas).max(axis=(0, 2)) > STILL
    face_moves = moves[source.faces].max(1)[correspondence]
    touched = np.bincount(target.faces[face_moves].ravel(), minlength=len(target.vertices))
    return np.flatnonzero(touched == 0)


def merged(rig: Rig, groups: dict[str, tuple[str, ...]] = FACS23) -> Rig:
    """A rig whose shapes are sums of `rig`'s.

    Raises:
        KeyError: a shape of a group is not in the rig.
    """
    deltas = np.stack([sum(rig.deltas[rig.index(name)] for name in names) for names in groups.values()])
    return Rig(rig.neutral, deltas, tuple(groups), rig.texture)
