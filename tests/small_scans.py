"""Small scans and rigs of scans for tests."""

from functools import cache

import numpy as np

from mien.clip import Markers
from mien.faces import load_face
from mien.mesh import Attachment, Mesh, closest_point, submesh
from mien.rig import Rig
from mien.scans.scan_rig import ScanRig
from mien.scans.scan_template import ScanTemplate, make_template
from mien.transforms import Transform, rotation_from_vector


def sheet(n: int = 15, size: float = 60.0) -> Mesh:
    """A gently domed square, face space."""
    x, y = np.meshgrid(np.linspace(-size, size, n), np.linspace(-size, size, n))
    vertices = np.column_stack([x.ravel(), y.ravel(), 80 - (x.ravel() ** 2 + y.ravel() ** 2) / 150])
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


@cache
def bundled_template() -> ScanTemplate:
    """The average face as a template, not subdivided."""
    face = load_face()
    return make_template(face.rig.neutral, face)


def plain_template(mesh: Mesh) -> ScanTemplate:
    """A mesh that is all skin."""
    n = len(mesh.vertices)
    one, nothing = np.ones(n), np.zeros(n)
    return ScanTemplate(
        mesh, np.arange(len(mesh.faces)), np.arange(n), mesh, one, {}, {}, one, nothing, nothing.astype(int)
    )


def front_of(mesh: Mesh) -> Mesh:
    """What a scan shows of the template's skin."""
    front = bundled_template().regions["face"] > 0.01
    return submesh(mesh, np.flatnonzero(front[mesh.faces].all(axis=1)))[0]


def markers_on(mesh: Mesh, count: int = 25, seed: int = 0) -> Attachment:
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.linspace(-45, 45, 5), np.linspace(-45, 45, 5)), -1).reshape(-1, 2)[:count]
    points = np.column_stack([grid + rng.uniform(-3, 3, grid.shape), np.full(len(grid), 60.0)])
    return closest_point(mesh, points).attachment()


def small_rig(seed: int = 0) -> ScanRig:
    """A sheet with three smooth targets and its markers, none of them standing off."""
    mesh, rng = sheet(), np.random.default_rng(seed)
    waves = rng.normal(size=(3, 2)) / 40
    deltas = np.stack([np.sin(mesh.vertices[:, :2] @ w)[:, None] * rng.normal(size=3) * 4 for w in waves])
    rig, place = Rig(mesh, deltas, ("smile", "frown", "pucker")), markers_on(mesh)
    shapes = np.concatenate([mesh.vertices[None], mesh.vertices + deltas])
    expressions = np.stack([place.points(mesh.with_vertices(x)) for x in shapes])
    labels = tuple(f"M{i:02d}" for i in range(len(place.faces)))
    return ScanRig(rig, "rest", labels, place, np.zeros(len(labels)), expressions, np.ones(len(labels), bool))


def play(found: ScanRig, weights: np.ndarray, seed: int = 3, extra: np.ndarray | None = None):
    """A take on the rig with a moving head; `extra` (frames, markers, 3) is added in face space."""
    rng = np.random.default_rng(seed)
    moved = found.expressions[0] + np.tensordot(weights, found.expressions[1:] - found.expressions[0], axes=1)
    moved = moved if extra is None else moved + extra
    turn = np.cumsum(rng.normal(size=(len(weights), 3)) * 0.004, axis=0)
    T = Transform(rotation_from_vector(turn), np.cumsum(rng.normal(size=(len(weights), 3)) * 0.3, axis=0))
    return Markers(T.apply(moved), found.labels, 60.0), T


def gestures(frames: int = 240, seed: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, frames)[:, None]
    weights = np.maximum(np.sin(2 * np.pi * (t * rng.uniform(2, 4, 3) + rng.random(3))) - 0.3, 0) * 0.8
    weights[:90] = 0
    return weights
