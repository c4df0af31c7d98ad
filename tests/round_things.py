"""Round meshes and a camera."""

import numpy as np

from mien.mesh import Mesh


def sphere(radius: float = 50.0, rings: int = 24, centre=(0.0, 0.0, 0.0)) -> Mesh:
    """A closed UV sphere."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    band = np.stack([np.sin(t) * np.sin(p), np.cos(t), np.sin(t) * np.cos(p)], -1).reshape(-1, 3)
    vertices = np.concatenate([band, [[0, 1, 0], [0, -1, 0]]]) * radius + centre
    n, top, bottom = len(phi), len(band), len(band) + 1
    faces = []
    for j in range(n):
        k = (j + 1) % n
        faces += [(top, j, k), (bottom, (rings - 2) * n + k, (rings - 2) * n + j)]
        for i in range(rings - 2):
            a, b, c, d = i * n + j, i * n + k, (i + 1) * n + j, (i + 1) * n + k
            faces += [(a, c, b), (b, c, d)]
    return Mesh(vertices, np.array(faces))
