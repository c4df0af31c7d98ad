"""Spheres and height fields."""

import numpy as np

from mien.mesh import Mesh


def height_field(height, size=20.0, count=41):
    x, y = np.meshgrid(np.linspace(-size, size, count), np.linspace(-size, size, count))
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return Mesh(np.stack([x, y, height(x, y)], -1).reshape(-1, 3), faces)
