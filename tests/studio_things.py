"""Small performances for the studio."""

import numpy as np

from mien.clip import Markers
from mien.faces import load_face
from mien.io.markers import write_c3d
from mien.mesh import Attachment, ClosestPoint, submesh, vertex_normals
from mien.rig import Performance
from mien.transforms import Transform, rotation_from_vector

RATE = 30.0


def nodding(frames=31, rig=None):
    """The bundled face smiles, opens its mouth, blinks, and turns its head before a camera."""
    rig = load_face().rig if rig is None else rig
    t = np.arange(frames) / RATE
    weights = np.zeros((frames, len(rig.names)))
    for name, phase in (("jawOpen", 0.0), ("mouthSmileLeft", 1.0), ("eyeBlinkRight", 2.0)):
        weights[:, rig.index(name)] = 0.5 + 0.5 * np.sin(3 * t + phase)
    turn = rotation_from_vector(np.stack([0.1 * np.sin(t), 0.2 * np.sin(2 * t), 0 * t], axis=1))
    place = np.stack([10 * np.sin(t), 1500 + 0 * t, 5 * t], axis=1)
    return Performance(rig, weights, Transform(turn, place), RATE, np.ones(frames, dtype=bool))


STANDOFF_MM = 4.0
"""Markers above the skin."""


def marked():
    """Eight places on the bundled face's skin, wide apart; the last one's marker is worn off the face."""
    face = load_face()
    mesh = face.rig.neutral
    spots = np.array(
        [
            [0, 45, 60],
            [40, 40, 45],
            [-40, 40, 45],
            [35, -10, 50],
            [-35, -10, 50],
            [25, -45, 55],
            [-25, -45, 55],
            [0, -70, 60],
        ]
    )
    skin = np.isin(mesh.faces, face.parts["skin"]).all(axis=1)
    part, _ = submesh(mesh, np.flatnonzero(skin))
    closest = ClosestPoint(part).query(spots.astype(float))
    return Attachment(np.flatnonzero(skin)[closest.faces], np.full((8, 3), 1 / 3))


def write_take(path, performance):
    """Markers M0 to M7 on a performance, M7 far before the throat."""
    rig, at, frames = performance.rig, marked(), []
    for weights in performance.weights:
        mesh = rig.neutral.with_vertices(rig.vertices(weights))
        above = (vertex_normals(mesh.vertices, mesh.faces)[mesh.faces[at.faces]]).mean(axis=1)
        frames.append(at.points(mesh) + STANDOFF_MM * above)
    frames = np.array(frames)
    frames[:, 7] += [0, 0, 95]
    world = np.stack([performance.T_world_face[t].apply(frames[t]) for t in range(len(frames))])
    write_c3d(path, Markers(world, tuple(f"M{m}" for m in range(8)), performance.rate))
