"""Normals of a rig's surface, and how each shape turns them: what files store beside positions."""

import numpy as np
from jaxtyping import Float

from ..mesh import vertex_normals
from .rig import Rig

_STILL = 1e-4
"""A shape turns a normal when its normal's tip moves by more than this, the step of a float16 near 0.1."""


def neutral_normals(rig: Rig) -> Float[np.ndarray, "n 3"]:
    """Unit normals of the neutral; +Z for a vertex of no triangle."""
    normals = vertex_normals(rig.neutral.vertices, rig.neutral.faces)
    normals[(normals == 0).all(axis=1)] = (0, 0, 1)
    return normals


def normal_offsets(rig: Rig, k: int, neutral: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """What shape `k` at weight 1 adds to the normals of the `neutral` (`neutral_normals`); 0 where it leaves them.

    Viewers add offsets by weight and make the sum a unit vector: exact for one shape at 0 and 1, and close in between.
    """
    turned = vertex_normals(rig.neutral.vertices + rig.deltas[k], rig.neutral.faces)
    alone = (turned == 0).all(axis=1)
    offsets = turned - neutral
    offsets[alone | (np.linalg.norm(offsets, axis=1) < _STILL)] = 0
    return offsets
