"""A rig and a performance to look at."""

import numpy as np

from mien.cli.main import app
from mien.mesh import Mesh, loop_refinement
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector


def ball() -> Mesh:
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(3):
        finer = loop_refinement(faces, len(vertices))
        vertices, faces = finer.between @ vertices, finer.faces
    return Mesh(80 * vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces)


def brows_and_cheeks() -> Rig:
    mesh = ball()
    up = np.clip(mesh.vertices[:, 1:2] / 80, 0, 1) * (0.0, 30.0, 0.0)
    out = np.clip(mesh.vertices[:, :1] / 80, 0, 1) * (30.0, 0.0, 0.0)
    return Rig(mesh, np.stack([up, out]), ("browUp", "cheekOut"))


def nodding(rig: Rig) -> Performance:
    """Nine frames: the first shape comes and goes while the head turns in a lab of its own."""
    count = 9
    phase = np.linspace(0, np.pi, count)
    turn = rotation_from_vector(np.stack([0 * phase, 0.5 * np.cos(phase), 0 * phase], 1))
    lab = rotation_from_vector(np.array([0.0, 2.5, 0.0]))
    place = np.stack([900 + 20 * np.sin(phase), 1500 + 0 * phase, -300 + 0 * phase], 1)
    weights = np.stack([np.sin(phase), 0 * phase], 1)
    return Performance(rig, weights, Transform(lab @ turn, place), 60.0, np.ones(count, bool))


def run(*words) -> None:
    app([str(word) for word in words], exit_on_error=False, result_action="return_value")
