"""Points spread over a surface, Loop subdivision, and values carried from one surface to another."""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from mien.errors import BadInput

from .closest import closest_point
from .mesh import Attachment, Mesh
from .operators import face_areas

CANDIDATES = 8
"""Random points drawn a point kept by `blue_noise`: more are more even and slower."""


def farthest_points(points: Float[np.ndarray, "n d"], count: int, start: int = 0) -> Int[np.ndarray, " count"]:
    """Indices of `count` points, each the farthest from all before it, `start` first (Gonzalez 1985).

    Raises:
        BadInput: more points asked for than there are.
    """
    if not 0 < count <= len(points):
        raise BadInput(f"farthest points: {count} asked for of {len(points)}; ask for 1 to {len(points)}")
    chosen = np.empty(count, np.int64)
    chosen[0] = start
    distance = ((points - points[start]) ** 2).sum(1)
    for i in range(1, count):
        chosen[i] = distance.argmax()
        np.minimum(distance, ((points - points[chosen[i]]) ** 2).sum(1), out=distance)
    return chosen


def random_points(mesh: Mesh, count: int, seed: int = 0) -> Attachment:
    """Points spread at random, evenly by area."""
    rng = np.random.default_rng(seed)
    areas = face_areas(mesh.vertices, mesh.faces)
    faces = rng.choice(len(areas), count, p=areas / areas.sum())
    root, share = np.sqrt(rng.random(count)), rng.random(count)
    return Attachment(faces, np.stack([1 - root, root * (1 - share), root * share], 1))


def blue_noise(mesh: Mesh, count: int, seed: int = 0) -> Attachment:
    """Points spread evenly at random, none close to another: the farthest of many random ones (straight distances)."""
    many = random_points(mesh, CANDIDATES * count, seed)
    keep = farthest_points(many.points(mesh), count)
    return Attachment(many.faces[keep], many.barycentric[keep])


def loop_subdivide(mesh: Mesh, times: int = 1) -> tuple[Mesh, sp.csr_matrix]:
    """The mesh with four triangles for each, smoothed by Loop's rules, and S (new, old): S @ vertices are its vertices.

    Old vertices stay first. S serves any vertex values, such as blendshapes. Borders follow themselves alone
    (cubic splines), and so do edges of more than two triangles. Texture coordinates go to edge middles, unsmoothed,
    so that seams stay where they are.
    """
    S = sp.identity(len(mesh.vertices), format="csr")
    for _ in range(times):
        step, faces = _loop_step(mesh.faces, len(mesh.vertices))
        uv, uv_faces = mesh.uv, mesh.uv_faces
        if uv is not None:
            seams = mesh.faces if uv_faces is None else uv_faces
            uv_edges, fine = _split(seams, len(uv))
            uv = np.concatenate([uv, uv[uv_edges].mean(axis=1)])
            uv_faces = None if uv_faces is None else fine
        colors = None if mesh.colors is None else np.clip(step @ mesh.colors, 0, 1)
        mesh = Mesh(step @ mesh.vertices, faces, uv, uv_faces, colors)
        S = step @ S
    return mesh, sp.csr_matrix(S)


def _split(faces: np.ndarray, n: int) -> tuple[Int[np.ndarray, "e 2"], Int[np.ndarray, "m4 3"]]:
    """Edges, in the order of their middles n, n + 1, ..., and the four triangles of each."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], -1).reshape(-1, 2)
    edges, index = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = n + index.reshape(-1, 3).T
    fine = [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    return edges, np.concatenate([np.stack(corner, 1) for corner in fine])


def _loop_step(faces: np.ndarray, n: int) -> tuple[sp.csr_matrix, Int[np.ndarray, "m4 3"]]:
    """One step's matrix and triangles (Loop 1987, with Warren's weights of the old vertices)."""
    edges, fine = _split(faces, n)
    middle = fine[-len(faces) :] - n
    opposite = np.roll(faces, 1, axis=1)
    count = np.bincount(middle.ravel(), minlength=len(edges))
    inner = count == 2
    E = sp.csr_matrix((np.ones(2 * len(edges)), (np.repeat(np.arange(len(edges)), 2), edges.ravel())), (len(edges), n))
    O = sp.csr_matrix((np.ones(faces.size), (middle.ravel(), opposite.ravel())), shape=(len(edges), n))
    odd = sp.diags(np.where(inner, 3 / 8, 1 / 2)) @ E + sp.diags(np.where(inner, 1 / 8, 0)) @ O
    on_border = np.zeros(n, bool)
    on_border[edges[~inner]] = True
    degree = np.bincount(edges.ravel(), minlength=n)
    beta = np.where(degree == 3, 3 / 16, 3 / (8 * np.maximum(degree, 1)))
    all_around, border_around = (_neighbours(edges[keep], n) for keep in (slice(None), ~inner))
    own = np.where(on_border, 1 - np.asarray(border_around.sum(1)).ravel() / 8, 1 - degree * beta)
    around = sp.diags(np.where(on_border, 0, beta)) @ all_around + border_around / 8
    return sp.csr_matrix(sp.vstack([sp.diags(own) + around, odd])), fine


def _neighbours(edges: np.ndarray, n: int) -> sp.csr_matrix:
    i, j = edges.T
    return sp.csr_matrix((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), shape=(n, n))


def transfer(source: Mesh, values: Float[np.ndarray, "n *c"], points: Float[np.ndarray, "p 3"]) -> np.ndarray:
    """Vertex values of `source` at the surface points closest to `points`: (p, *c)."""
    D = closest_point(source, points).attachment().matrix(source)
    return (D @ values.reshape(len(values), -1)).reshape(len(points), *values.shape[1:])
