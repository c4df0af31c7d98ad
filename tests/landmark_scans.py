"""Scans with landmarks."""

import numpy as np

from mien.faces.bundled import load_face
from mien.landmarks.lift import LiftConfig
from mien.mesh import Mesh

QUICK = LiftConfig(zooms=(), sweep_pixels=256, pixels=400, views=((0.0, 0.0), (-0.25, 0.0), (0.25, 0.0)))


def somebody() -> Mesh:
    coefficients = np.random.default_rng(2).normal(size=20)
    return load_face().person(coefficients).neutral
