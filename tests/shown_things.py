"""A rig and a performance to look at."""

import numpy as np

from mien.cli.main import app
from mien.mesh import Mesh, loop_refinement


def ball() -> Mesh:
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(3):
        finer = loop_refinement(faces, len(vertices))
        vertices, faces = finer.between @ vertices, finer.faces
    return Mesh(80 * vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces)


def run(*words) -> None:
    app([str(word) for word in words], exit_on_error=False, result_action="return_value")
