"""Small performances for the studio."""

import numpy as np

from mien.faces import load_face
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
