"""What is done to a scan before anything is fitted to it: weld, drop what is no surface, turn the right side out."""

from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from ..io.meshes import check_surface
from ..mesh import Mesh, Scan, adjacency, connected_parts, edge_ends, face_areas, face_normals
from ..pictures.raycast import RayCaster

ROUGH_DEG = 20.0
"""Real and staged scans have 2 to 10, one with half a millimetre of noise a vertex 80."""
EVENING_ROUNDS = 30
"""At most."""


def cleaned(mesh: Mesh) -> Mesh:
    """The scan's surface: duplicated vertices made one, triangles without area left out, normals outward.

    Texture coordinates and colours are dropped; vertices get new numbers.
    """
    return mended(mesh)[0]


def mended(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """`cleaned`, and what was wrong: one plain line a fault."""
    once = welded(mesh)
    right = outward(once)
    notes = []
    double = len(np.unique(mesh.faces)) - len(once.vertices)
    if double > 0:
        notes.append(f"{double} duplicated vertices made one with their twins")
    dropped = len(mesh.faces) - len(once.faces)
    if dropped:
        notes.append(f"{dropped} triangles without area or given twice left out")
    forks = fork_edges(once.faces)
    if forks:
        notes.append(f"{forks} edges of more than two triangles (non-manifold) left as they are")
    turned = int((right.faces != once.faces).any(axis=1).sum())
    if turned:
        notes.append(f"{turned} of {len(once.faces)} triangles showed their inner side: turned outward")
    return right, tuple(notes)


def fork_edges(faces: Int[np.ndarray, "m 3"]) -> int:
    """How many edges have more than two triangles."""
    return int((np.unique(edge_ends(faces), axis=0, return_counts=True)[1] > 2).sum())


def check_scan(scan: Scan) -> None:
    """Refuse what is no surface.

    Raises:
        BadInput: no vertices, no triangles, a vertex that is not finite.
    """
    check_surface(Path(scan.name or "scan"), scan.mesh)


def welded(mesh: Mesh) -> Mesh:
    """Vertices in the same place (to a millionth of the scan's size) become one; flat and double triangles go."""
    size = float(np.ptp(mesh.vertices, axis=0).max()) or 1.0
    keys = np.round((mesh.vertices - mesh.vertices.min(axis=0)) / (1e-6 * size)).astype(np.int64)
    _, first, where = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    faces = where.reshape(-1)[mesh.faces]
    vertices = mesh.vertices[first]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    proper[proper] &= face_areas(vertices, faces[proper]) > 1e-14 * size**2
    faces = faces[proper]
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    faces = faces[np.sort(once)]
    used, renumbered = np.unique(faces, return_inverse=True)
    return Mesh(vertices[used], renumbered.reshape(-1, 3))


def outward(mesh: Mesh, pixels: int = 64) -> Mesh:
    """Triangles wound alike within each piece, and each piece so that it shows its outer side to the world.

    Pieces that nobody sees from outside keep the side that most of the scan has.
    """
    faces, piece = _wound_alike(mesh.faces)
    alike = Mesh(mesh.vertices, faces)
    votes = _votes(alike, pixels)
    count = int(piece.max()) + 1 if len(piece) else 0
    total = np.bincount(piece, votes, minlength=count)
    most = 1.0 if votes.sum() >= 0 else -1.0
    flip = np.where(total == 0, most, total)[piece] < 0
    return Mesh(mesh.vertices, np.where(flip[:, None], faces[:, ::-1], faces))


def wound_alike(mesh: Mesh) -> Mesh:
    """The same mesh with neighbouring triangles wound alike; texture coordinates and colours stay where they are."""
    faces, _ = _wound_alike(mesh.faces)
    if mesh.uv_faces is None:
        return replace(mesh, faces=faces)
    corner = (faces[:, :, None] == mesh.faces[:, None, :]).argmax(axis=2)
    return replace(mesh, faces=faces, uv_faces=np.take_along_axis(mesh.uv_faces, corner, axis=1))


def evened(mesh: Mesh, rough_deg: float = ROUGH_DEG) -> Mesh:
    """The same mesh with so much noise taken out that a picture of it shows its shape; a clean one as it is.

    While neighbouring triangles usually differ by more than `rough_deg`, each vertex goes half way to the middle of
    its neighbours. The surface moves by about its noise.
    """
    vertices, n = mesh.vertices, len(mesh.vertices)
    A = adjacency(mesh.faces, n)
    middle = sp.diags(1 / np.maximum(np.asarray(A.sum(axis=1)).ravel(), 1)) @ A
    lonely = (A.getnnz(axis=1) == 0)[:, None]
    for _ in range(EVENING_ROUNDS):
        if roughness_deg(vertices, mesh.faces) <= rough_deg:
            break
        vertices = np.where(lonely, vertices, (vertices + middle @ vertices) / 2)
    return mesh.with_vertices(vertices)


def roughness_deg(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> float:
    """Median angle between triangles that share an edge, degrees; 0 where none do."""
    normals = face_normals(vertices, faces)
    ends = edge_ends(faces.astype(np.int64))
    edge = ends[:, 0] * len(vertices) + ends[:, 1]
    order = np.argsort(edge, kind="stable")
    triangle = order // 3
    shared = np.flatnonzero(edge[order[1:]] == edge[order[:-1]])
    cosine = np.einsum("ed,ed->e", normals[triangle[shared]], normals[triangle[shared + 1]])
    return float(np.degrees(np.median(np.arccos(np.clip(cosine, -1, 1))))) if len(shared) else 0.0


def _wound_alike(faces: Int[np.ndarray, "m 3"]) -> tuple[Int[np.ndarray, "m 3"], Int[np.ndarray, " m"]]:
    """Faces with neighbours wound alike, and which piece each is in."""
    directed = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)
    keys = directed[:, 0] * (int(faces.max()) + 1) + directed[:, 1]
    if len(np.unique(keys)) == len(keys):
        return faces.astype(np.int64), connected_parts(faces, int(faces.max()) + 1)[faces[:, 0]]
    alike, piece = igl.bfs_orient(faces.astype(np.int64))
    return np.asarray(alike).astype(np.int64), np.asarray(piece).astype(np.int64).reshape(-1)


def _votes(mesh: Mesh, pixels: int) -> Float[np.ndarray, " m"]:
    """For each triangle: how often it is seen from outside, from its outer side less from its inner one."""
    centre = (mesh.vertices.min(0) + mesh.vertices.max(0)) / 2
    radius = float(np.linalg.norm(mesh.vertices - centre, axis=1).max())
    caster, normals = RayCaster(mesh), face_normals(mesh.vertices, mesh.faces)
    votes = np.zeros(len(mesh.faces))
    u, v = np.meshgrid(*[np.linspace(-radius, radius, pixels)] * 2)
    for way in (*np.eye(3), *-np.eye(3)):
        a, b = np.roll(way, 1), np.roll(way, 2)
        origins = centre - 2 * radius * way + u.reshape(-1, 1) * a + v.reshape(-1, 1) * b
        hits = caster.cast(origins, np.broadcast_to(way, origins.shape))
        seen = hits.faces[hits.hit]
        votes += np.bincount(seen, -(normals[seen] @ way), minlength=len(votes))
    return votes
