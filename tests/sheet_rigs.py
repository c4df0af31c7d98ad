"""Rigs on sheets, and one on a head of another topology."""

from functools import cache

import igl
import numpy as np

import tracking_stage as stage
from mien.faces import load_face
from mien.landmarks.on_rig import attach_landmarks
from mien.mesh import ClosestPoint, Mesh, loop_subdivide, submesh
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector


def sheet(n, size=60.0):
    """A domed sheet of n x n vertices, the same surface for every n."""
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n)))
    vertices = size * np.stack([x, y, 0.5 * np.exp(-2 * x**2 - 2 * y**2)], 1)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def performed(rig, weights):
    t = len(weights)
    turn = rotation_from_vector(np.linspace(0, 0.3, t)[:, None] * [0, 1, 0])
    return Performance(rig, weights, Transform(turn, np.ones((t, 3))), 30.0, np.ones(t, bool))


SIZE = 1.15
"""How much larger than life the other person's head is."""


@cache
def acting():
    """Somebody whose cheek bulges as no blendshape can say, speaking and turning."""
    rig = stage.person(1)
    spot = stage.landmarks().attachment.points(rig.neutral)[425]
    near = np.exp(-((rig.neutral.vertices - spot) ** 2).sum(1) / 20**2)
    near = np.maximum(near - 0.01, 0)[:, None]
    full = Rig(rig.neutral, np.concatenate([rig.deltas, (near * [3, 0, 5])[None]]), (*rig.names, "corrective_01"))
    weights = np.zeros((3, len(full.names)))
    weights[1:, full.index("jawOpen")], weights[1:, -1] = 0.5, (1, -0.5)
    return performed(full, weights)


@cache
def remeshed():
    """Another person, larger, skin alone, subdivided, then decimated; landmarks; and what carries shapes over."""
    other = stage.person(7)
    skin = np.isin(other.neutral.faces, load_face().parts["skin"]).all(axis=1)
    mesh, old = submesh(other.neutral, np.flatnonzero(skin))
    fine, matrix = loop_subdivide(mesh)
    vertices, faces = (np.asarray(a) for a in igl.decimate(fine.vertices, fine.faces.astype(np.int64), 9000)[:2])
    near = ClosestPoint(fine).query(vertices)

    def carried(shape):
        return SIZE * np.einsum("pc,pcd->pd", near.barycentric, (matrix @ shape[old])[fine.faces[near.faces]])

    neutral = Mesh(SIZE * vertices, np.array(faces.tolist()))
    rig = Rig(neutral, np.stack([carried(delta) for delta in other.deltas]), other.names)
    points = SIZE * stage.landmarks().attachment.points(other.neutral)
    return rig, attach_landmarks(rig.neutral, points, np.ones(len(points), bool)), carried
