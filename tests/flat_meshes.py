"""A triangle and a grid."""

import numpy as np

from mien.mesh import (
    Mesh,
)

RNG = np.random.default_rng(1)


RIGHT = Mesh(np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0]]), np.array([[0, 1, 2]]))


def grid(n: int = 6) -> Mesh:
    """A flat square of n x n vertices, 1 mm apart."""
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], 1).astype(float)
    a = (np.arange(n * (n - 1)).reshape(n - 1, n)[:, :-1]).ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)]))
