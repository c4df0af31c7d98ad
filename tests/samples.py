"""Samples of a surface."""

import numpy as np


def surface_samples(rng, count=300):
    return {
        "normals": rng.normal(size=(count, 3)).astype(np.float32) * 3,
        "points": (rng.normal(size=(count, 3)) * 50 + (0, 0, 400)).astype(np.float32),
    }
