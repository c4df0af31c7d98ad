"""The smooth neutral mesh that displacements count from: the training skin without its detail, on few vertices."""

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import splu

from ..errors import BadInput
from ..mesh import (
    Attachment,
    ClosestPoint,
    Mesh,
    adjacency,
    cotangent_laplacian,
    face_normals,
    in_largest_part,
    mass,
    submesh,
    vertex_normals,
)
from ..mesh.cylinder import fit_cylinder
from ..pictures.eyes import eyeballs
from ..pictures.raycast import RayCaster
from .texture_space import with_texture

LIFT_MM = 0.5
"""How far off the skin a ray that asks for open sky begins."""
LEAST_COSINE = -0.1
"""Between a triangle's normal and the way out: below it the skin looks inwards, as the backs of lips and lids do."""
RIM_MM = 15.0
"""How far along the skin lids, lips and nostrils are followed inwards from the base's rim."""
OVERLAP_MM, UNDER_MM = 6.0, 0.3
"""How far they go on under the base, and how far below it."""
OPENING = 2
"""Rings of vertices that are taken off and put back, so that no thread of skin is left hanging in the mouth."""


@dataclass(frozen=True)
class BaseConfig:
    """How the base mesh is made."""

    vertices: int = 10_000
    """About so many; 0: as many as the training skin has."""
    smoothing_mm: float = 8.0
    """Half wavelength below which the neutral's shape is taken for detail, mm; 0: the neutral as it is."""


@dataclass(frozen=True)
class BaseMesh:
    """The base at rest, and how its points are found on the training skin."""

    mesh: Mesh
    """Smooth, open, with one-to-one texture coordinates; face space, mm."""
    skin: Mesh
    """The training topology's outer skin, smoothed likewise."""
    faces: np.ndarray
    """Which triangles of the training topology those of `skin` are."""

    def on_training(self, points: Attachment) -> Attachment:
        """Points of the base, on the training topology: the nearest ones of the smoothed skin."""
        found = ClosestPoint(self.skin).query(points.points(self.mesh))
        return Attachment(self.faces[found.faces], found.barycentric)


def base_mesh(neutral: Mesh, config: BaseConfig = BaseConfig()) -> BaseMesh:
    """Outer skin, smoothed, decimated, unrolled.

    Raises:
        BadInput: no outer skin, or one that closes all round the head.
    """
    kept = np.flatnonzero(outer_skin(neutral))
    skin, _ = submesh(neutral, kept)
    smoothed = skin.with_vertices(smooth_surface(skin, config.smoothing_mm))
    base = with_texture(decimated(smoothed, config.vertices))
    return BaseMesh(_as_stored(base), smoothed, kept)


def rims_and_eyes(neutral: Mesh, base: BaseMesh) -> Mesh | None:
    """What no map covers and a picture asks for: lids, lips and nostrils up to `RIM_MM` beyond the base, and eyeballs.

    Texture coordinates are those of the place on the base that a vertex goes with, found along the surface, and -1 on
    eyeballs. A strip goes on under the base, whose rim smoothing has drawn back. None where there is nothing.
    """
    n = len(neutral.vertices)
    eyes, on_base = eyeballs(neutral), np.zeros(n, bool)
    on_base[neutral.faces[base.faces]] = True
    i, j = neutral.faces[:, [0, 1, 2]].ravel(), neutral.faces[:, [1, 2, 0]].ravel()
    length = np.linalg.norm(neutral.vertices[i] - neutral.vertices[j], axis=1)
    graph = sp.csr_matrix((length, (i, j)), shape=(n, n))
    graph = graph.maximum(graph.T)
    inwards = dijkstra(graph, indices=np.flatnonzero(~on_base), limit=OVERLAP_MM, min_only=True)
    away, _, source = dijkstra(
        graph, indices=np.flatnonzero(on_base), return_predecessors=True, limit=RIM_MM, min_only=True
    )
    near = np.isfinite(away)
    kept = ((np.isfinite(inwards) & near) | eyes)[neutral.faces].all(axis=1)
    if not kept.any():
        return None
    parts, used = submesh(neutral, np.flatnonzero(kept))
    uv = np.full((len(used), 2), -1.0)
    uv[near[used]] = _uv_of(base, np.searchsorted(np.flatnonzero(on_base), source[used][near[used]]))
    normals = vertex_normals(parts.vertices, parts.faces)
    under = np.where(on_base[used], UNDER_MM, 0.0)[:, None] * normals
    return Mesh(parts.vertices - under, parts.faces, uv)


def _uv_of(base: BaseMesh, vertices: Int[np.ndarray, " n"]) -> Float[np.ndarray, "n 2"]:
    """Texture coordinates of vertices of the smoothed skin: those of the base's points nearest to them."""
    assert base.mesh.uv is not None
    at = ClosestPoint(base.mesh).query(base.skin.vertices[vertices]).attachment()
    return np.einsum("pc,pcd->pd", at.barycentric, base.mesh.uv[base.mesh.faces[at.faces]])


def _as_stored(mesh: Mesh) -> Mesh:
    """In the precision of files, so that what is fitted here is found again when the base is read."""
    assert mesh.uv is not None
    return Mesh(mesh.vertices.astype(np.float32).astype(float), mesh.faces, mesh.uv.astype(np.float32).astype(float))


def outer_skin(mesh: Mesh) -> Bool[np.ndarray, " m"]:
    """Triangles that see the sky straight out from the head's axis, in one piece: no sock, no backs of lids, no eyes.

    Raises:
        BadInput: nothing does.
    """
    cylinder = fit_cylinder(mesh)
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    out = (middle - [cylinder.x, 0.0, cylinder.z]) * [1.0, 0.0, 1.0]
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
    normals = face_normals(mesh.vertices, mesh.faces)
    blocked = RayCaster(mesh).cast(middle + LIFT_MM * normals, out).hit
    seen = ~blocked & ((normals * out).sum(axis=1) > LEAST_COSINE)
    seen = _opened(mesh, seen)
    if not seen.any():
        raise BadInput("detail: no outer skin in the neutral mesh; is it a face with +Z out and normals outwards?")
    while True:
        kept = np.flatnonzero(seen)
        seen[kept] = in_largest_part(mesh.faces[kept], len(mesh.vertices))
        pinched = _pinched(mesh.faces, seen)
        if not pinched.any():
            return seen
        seen &= ~pinched[mesh.faces].any(axis=1)


def _pinched(faces: np.ndarray, seen: Bool[np.ndarray, " m"]) -> Bool[np.ndarray, " n"]:
    """Vertices at which two sheets of the chosen triangles touch in a point alone: no surface there."""
    kept, count = faces[seen], int(faces.max()) + 1
    corner = np.arange(3 * len(kept)).reshape(-1, 3)
    ends, sides = [], []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        low = np.minimum(kept[:, i], kept[:, j]) * count + np.maximum(kept[:, i], kept[:, j])
        swap = kept[:, i] > kept[:, j]
        ends.append(low)
        first, second = corner[:, i], corner[:, j]
        sides.append(np.stack([np.where(swap, second, first), np.where(swap, first, second)], 1))
    key, side = np.concatenate(ends), np.concatenate(sides)
    order = np.argsort(key, kind="stable")
    twin = np.flatnonzero(np.diff(key[order]) == 0)
    a, b = side[order[twin]].ravel(), side[order[twin + 1]].ravel()
    joined = sp.csr_matrix((np.ones(len(a)), (a, b)), shape=(corner.size, corner.size))
    fans = connected_components(joined, directed=False)[1]
    _fan, first = np.unique(fans, return_index=True)
    return np.bincount(kept.ravel()[first], minlength=count) > 1


def _opened(mesh: Mesh, seen: Bool[np.ndarray, " m"]) -> Bool[np.ndarray, " m"]:
    """Morphological opening: narrow bridges go, broad skin stays."""
    n = len(mesh.vertices)
    A = adjacency(mesh.faces, n)
    inner = np.ones(n, bool)
    inner[mesh.faces[~seen]] = False
    for _ in range(OPENING - 1):
        inner &= ~(A @ (~inner).astype(float) > 0)
    for _ in range(OPENING):
        inner |= A @ inner.astype(float) > 0
    return seen & inner[mesh.faces].all(axis=1)


def smooth_surface(mesh: Mesh, half_wavelength_mm: float) -> Float[np.ndarray, "n 3"]:
    """Vertices without detail shorter than a half wavelength: (M + s L M^-1 L) x = M x0, s = (length / pi)^4.

    x is the real part of (M + i sqrt(s) L)^-1 M x0, as 1 / (1 + a^2) = Re 1 / (1 + i a): L alone is factorised.
    Vertices are shuffled first: minimum degree breaks ties by order, and on a subdivided skin of 149,000 vertices the
    factor took 43 s where it takes 3.
    """
    if half_wavelength_mm <= 0:
        return mesh.vertices
    L, area = cotangent_laplacian(mesh.vertices, mesh.faces), mass(mesh.vertices, mesh.faces)
    area = np.maximum(area, 1e-3 * area.mean())
    A = sp.csr_matrix(sp.diags(area) + 1j * (half_wavelength_mm / np.pi) ** 2 * L)
    shuffled = np.random.default_rng(0).permutation(len(area))
    mixed = sp.csc_matrix(A[shuffled][:, shuffled])
    factor = splu(mixed, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    load = area[:, None] * mesh.vertices
    out = np.empty_like(load)
    out[shuffled] = factor.solve(load[shuffled].astype(complex)).real
    return out


def decimated(mesh: Mesh, vertices: int) -> Mesh:
    """The mesh with about so many vertices (quadric error, libigl); unchanged where it has no more.

    Raises:
        BadInput: edges of more than two triangles.
    """
    if vertices == 0 or len(mesh.vertices) <= vertices:
        return Mesh(mesh.vertices, mesh.faces, mesh.uv, mesh.uv_faces)
    made = igl.decimate(np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces, np.int64), 2 * vertices)
    corners, faces = np.asarray(made[0], float), np.asarray(made[1], np.int64)
    if not len(faces):
        raise BadInput("detail: the neutral mesh cannot be decimated: edges of more than two triangles; clean it first")
    return Mesh(corners, faces)
