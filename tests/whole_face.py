"""The bundled face and places on it."""

import numpy as np

FLIP = np.array([-1, 1, 1])


def delta(face, name):
    return face.rig.deltas[face.rig.index(name)]


def shape(rig, *names):
    return rig.vertices(np.isin(rig.names, names).astype(float))


def chin(face):
    """The foremost vertex of the chin, on the mirror plane."""
    v = face.rig.neutral.vertices
    middle = np.flatnonzero((np.abs(v[:, 0]) < 1e-6) & (v[:, 1] < -92) & (v[:, 1] > -112))
    return middle[v[middle, 2].argmax()]
