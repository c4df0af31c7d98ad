"""What drives a displacement map: the deformation round every marker, in two directions (Ma et al. 2008, sec. 4.1)."""

from collections import deque
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from ..errors import BadInput
from ..mesh import Attachment, Mesh, adjacency
from ..solve.hull import hulls, nearest_in_hulls
from .marker_mesh import MarkerMesh

SIZE = 5
"""Entries of a deformation vector: an offset in three directions and two strains, mm."""


@dataclass(frozen=True)
class DomainConfig:
    """What of the deformation counts."""

    offsets: bool = True
    """Offsets O beside the strains E; False: strain alone, as in the paper's figure 4, left."""
    edge_strain: bool = False
    """Strain of the edges at a marker (Bickel et al. 2008) in place of the spread of its two-ring (eq. 2)."""
    threshold_deg: float = 45.0
    """Bases are smoothed until none is farther than this from the average of its neighbours; 90: not at all."""
    most_replacements: int = 10
    """Of one marker; where neighbours contradict each other no average lies within the threshold of all."""


@dataclass(frozen=True)
class Strains:
    """The neighbourhood of every marker, and the axes along which its strain is measured."""

    reference: Float[np.ndarray, "k 3"]
    """Markers at the neutral, mm."""
    ring: sp.csr_matrix
    """(k, k), rows of equal weights that add up to 1: the markers within two edges, itself among them (N2)."""
    axes: Float[np.ndarray, "k 2 3"]
    """The texture's u and v at each marker, unit vectors at the neutral."""
    scale: Float[np.ndarray, " k"]
    """sqrt |N2|: strains are multiplied by it, as a mean of many is less noisy than an offset (sec. 4.1)."""
    config: DomainConfig


@dataclass(frozen=True)
class Domain:
    """Two directions of deformation at every marker: the parameters of eq. 1."""

    strains: Strains
    coarse: MarkerMesh
    bases: Float[np.ndarray, "k 5 2"]
    """Q and R, smoothed; orthonormal at each marker."""
    energies: Float[np.ndarray, " 5"]
    """Share of the deformation that the first 1 to 5 directions hold, averaged over the markers (table 1)."""
    replaced: int
    """Markers whose bases smoothing replaced."""
    trained: Float[np.ndarray, "k e 2"]
    """Convex hull, at each marker, of d1 and d2 over the training frames and the neutral, mm."""

    def vectors(self, positions: Float[np.ndarray, "frames k 3"]) -> Float[np.ndarray, "frames k 5"]:
        """`deformation_vectors` whose d1 and d2 lie between those of training: the nearest there in place of others.

        Beyond what it was fitted to a polynomial of few frames goes anywhere, and a d1 of one expression beside a d2 of
        another is beyond.
        """
        free = deformation_vectors(self.strains, positions)
        d = np.einsum("tka,kad->tkd", free, self.bases)
        return free + np.einsum("tkd,kad->tka", nearest_in_hulls(d, self.trained) - d, self.bases)


def marker_strains(
    mesh: Mesh, attachment: Attachment, reference: Float[np.ndarray, "k 3"], coarse: MarkerMesh,
    gradients: tuple[sp.csr_matrix, sp.csr_matrix], config: DomainConfig = DomainConfig(),
) -> Strains:  # fmt: skip
    """Rings and axes of the markers.

    Args:
        mesh: the base mesh at rest, `with_texture`; `gradients` are its `texture_gradients`.
        reference: the markers of the neutral frame, face space, mm.
    """
    k = len(reference)
    joined = adjacency(coarse.triangles, k) + sp.identity(k)
    near = joined if config.edge_strain else joined @ joined
    ring = sp.csr_matrix(near)
    ring.data[:] = 1.0
    count = np.asarray(ring.sum(axis=1)).ravel()
    D = attachment.matrix(mesh)
    axes = np.stack([D @ (gradient @ mesh.vertices) for gradient in gradients], 1)
    axes = axes / np.maximum(np.linalg.norm(axes, axis=2, keepdims=True), 1e-12)
    return Strains(reference, sp.csr_matrix(sp.diags(1 / count) @ ring), axes, np.sqrt(count), config)


def deformation_vectors(
    strains: Strains, positions: Float[np.ndarray, "frames k 3"]
) -> Float[np.ndarray, "frames k 5"]:
    """S of every marker in every frame, mm: offset, and the strains of eq. 2 times sqrt |N2|.

    Args:
        positions: markers aligned rigidly with the neutral.

    Raises:
        BadInput: a marker that is missing, or another number of markers.
    """
    if positions.shape[1:] != strains.reference.shape:
        raise BadInput(
            f"detail: {positions.shape[1]} markers where the maps were made for {len(strains.reference)}; "
            "give a take with the same labels, or place the new markers first"
        )
    if not np.isfinite(positions).all():
        frame, marker, _ = np.argwhere(~np.isfinite(positions))[0]
        raise BadInput(f"detail: marker {marker} is missing in frame {frame}; fill the gaps first")
    out = np.empty((*positions.shape[:2], SIZE))
    out[..., :3] = positions - strains.reference if strains.config.offsets else 0.0
    measure = _edge_strain if strains.config.edge_strain else _spread_strain
    for axis in range(2):
        out[..., 3 + axis] = measure(strains, positions, axis) * strains.scale
    return out


def _spread_strain(strains: Strains, positions: np.ndarray, axis: int) -> Float[np.ndarray, "frames k"]:
    """Eq. 2: by how much the ring's standard deviation along an axis has grown, mm."""
    now = _deviation(strains, positions, axis)
    return now - _deviation(strains, strains.reference[None], axis)


def _deviation(strains: Strains, positions: np.ndarray, axis: int) -> Float[np.ndarray, "frames k"]:
    direction = strains.axes[:, axis]
    moments = np.zeros((len(positions), len(direction)))
    mean = np.stack([(strains.ring @ positions[..., d].T).T for d in range(3)], -1)
    for a in range(3):
        for b in range(3):
            product = (strains.ring @ (positions[..., a] * positions[..., b]).T).T
            moments += direction[:, a] * direction[:, b] * (product - mean[..., a] * mean[..., b])
    return np.sqrt(np.maximum(moments, 0.0))


def _edge_strain(strains: Strains, positions: np.ndarray, axis: int) -> Float[np.ndarray, "frames k"]:
    """Growth of the edges at a marker, weighted by how far each runs along the axis, mm (after Bickel et al. 2008)."""
    i, j = sp.coo_matrix(strains.ring).coords
    away = i != j
    i, j = i[away], j[away]
    edge = strains.reference[j] - strains.reference[i]
    length = np.linalg.norm(edge, axis=1)
    growth = np.linalg.norm(positions[:, j] - positions[:, i], axis=2) - length
    along = ((edge / length[:, None] * strains.axes[i, axis]).sum(axis=1)) ** 2
    total = sp.csr_matrix((along, (i, np.arange(len(i)))), shape=(len(strains.reference), len(i)))
    weight = np.maximum(np.asarray(total.sum(axis=1)).ravel(), 1e-9)
    return (total @ growth.T).T / weight


def fit_domain(strains: Strains, coarse: MarkerMesh, vectors: Float[np.ndarray, "frames k 5"]) -> Domain:
    """The two strongest directions at every marker, made to agree with their neighbours' (sec. 4.1, eq. 3).

    The second moment about the neutral, not about the mean, so that d = 0 at the neutral.
    """
    moments = np.einsum("tka,tkb->kab", vectors, vectors) / len(vectors)
    values, directions = np.linalg.eigh(moments)
    values, directions = values[:, ::-1], directions[:, :, ::-1]
    total = values.sum(axis=1)
    moving = total > 0
    if not moving.any():
        raise BadInput("detail: no marker moves in the training clips; there is nothing to learn from")
    energies = np.cumsum(values[moving] / total[moving, None], axis=1).mean(axis=0)
    bases = agreeing_planes(coarse, directions[:, :, :2], total)
    smooth, replaced = smooth_bases(coarse, bases, strains.config)
    d = np.einsum("tka,kad->tkd", vectors, smooth)
    trained = hulls(np.concatenate([d, np.zeros_like(d[:1])]))
    return Domain(strains, coarse, smooth, energies, replaced, trained)


def agreeing_planes(
    coarse: MarkerMesh, bases: Float[np.ndarray, "k 5 2"], energy: Float[np.ndarray, " k"]
) -> Float[np.ndarray, "k 5 2"]:
    """Bases turned within their planes to be as near to a neighbour's as they can be, outwards from the strongest.

    A principal direction has no sign, and where two are about equally strong neighbours may have them swapped. Over a
    spanning tree each child's basis is turned (or mirrored) in its own plane: B U V' with U S V' = B'A of the parent A.
    """
    bases, around = bases.copy(), neighbours(coarse, len(bases))
    waiting = np.ones(len(bases), bool)
    for root in np.argsort(-energy):
        queue = deque([root] if waiting[root] else [])
        waiting[root] = False
        while queue:
            parent = queue.popleft()
            for child in around[parent]:
                if waiting[child]:
                    u, _, vt = np.linalg.svd(bases[child].T @ bases[parent])
                    bases[child] = bases[child] @ (u @ vt)
                    waiting[child] = False
                    queue.append(child)
    return bases


def smooth_bases(
    coarse: MarkerMesh, bases: Float[np.ndarray, "k 5 2"], config: DomainConfig = DomainConfig()
) -> tuple[Float[np.ndarray, "k 5 2"], int]:
    """The worst outlier is replaced by the average of its neighbours until none is off by more than a threshold.

    The paper does not state the threshold, and replaces one vector at a time: two neighbours then undo each other for
    ever. Here both vectors of the worst marker are replaced. Returns the bases and how many markers were.
    """
    bases, around = bases.copy(), neighbours(coarse, len(bases))
    angles = np.array([_angles(bases, i, around[i]) for i in range(len(bases))])
    times = np.zeros(len(bases), int)
    while True:
        open_ = np.where(times < config.most_replacements, angles.max(axis=1), 0.0)
        worst = int(open_.argmax())
        if open_[worst] <= np.deg2rad(config.threshold_deg):
            return bases, int(times.sum())
        bases[worst] = _replaced(bases, around[worst])
        times[worst] += 1
        for i in map(int, (worst, *around[worst])):
            angles[i] = _angles(bases, i, around[i])


def neighbours(coarse: MarkerMesh, k: int) -> list[Int[np.ndarray, " _"]]:
    """The markers that share an edge with each."""
    joined = adjacency(coarse.triangles, k)
    return [joined.indices[joined.indptr[m] : joined.indptr[m + 1]] for m in range(k)]


def _angles(bases: np.ndarray, i: int, around: np.ndarray) -> Float[np.ndarray, " 2"]:
    """Between each vector of marker i and the average of its neighbours', radians."""
    if not len(around):
        return np.zeros(2)
    mean = bases[around].mean(axis=0)
    cosine = (mean * bases[i]).sum(axis=0) / np.maximum(np.linalg.norm(mean, axis=0), 1e-12)
    return np.arccos(np.clip(cosine, -1, 1))


def _replaced(bases: np.ndarray, around: np.ndarray) -> Float[np.ndarray, "5 2"]:
    """The neighbours' average basis made orthonormal: its polar factor, which favours neither vector."""
    u, _, vt = np.linalg.svd(bases[around].mean(axis=0), full_matrices=False)
    return u @ vt
