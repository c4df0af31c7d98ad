"""Two lips, or two lids, are different surfaces though they touch: matches from one to the other are forbidden."""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree


def same_side(
    vertices: Float[np.ndarray, "n 3"], sides: Int[np.ndarray, " n"], found: Float[np.ndarray, "n 3"]
) -> Bool[np.ndarray, " n"]:
    """False where a vertex of side s (not 0) found a point that lies nearest to a vertex of side -s.

    Args:
        vertices: the template as it stands now, mm.
        sides: +1 and -1 for the two lips, +2 and -2 for one eye's lids, ...; 0 elsewhere.
        found: each vertex's closest point on the target, mm.
    """
    allowed = np.ones(len(vertices), bool)
    marked = np.flatnonzero(sides)
    if len(marked):
        nearest = KDTree(vertices[marked]).query(found[marked])[1]
        allowed[marked] = sides[marked[nearest]] != -sides[marked]
    return allowed
