"""A square and a ball before a camera."""

import numpy as np

from mien.camera import Camera
from mien.mesh import Mesh, loop_refinement
from mien.pictures import Look
from mien.transforms import Transform

FLAT = Look(supersample=1, occlusion=0, softness=0.0, value_shading=0.0)
"""A heat map's colours and nothing else."""


CAMERA = Camera(100.0, 100.0, 15.5, 15.5, 32, 32)


FACING = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 200.0]))


def square(half: float = 20.0, z: float = 0.0, **more) -> Mesh:
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), **more)


def ball(radius: float = 50.0, centre=(0.0, 0.0, 0.0), rounds: int = 4) -> Mesh:
    """An octahedron, split and pushed out to the sphere."""
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(rounds):
        finer = loop_refinement(faces, len(vertices))
        vertices, faces = finer.between @ vertices, finer.faces
        vertices = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    return Mesh(vertices * radius + centre, faces)
