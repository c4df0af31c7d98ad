"""Markers laid over the performance that was solved from them."""

from itertools import product

import numpy as np
from jaxtyping import Float
from scipy.spatial import cKDTree

from ..clip import Markers
from ..errors import BadInput
from ..rig import Performance

TRIED = 12
"""Frames in which a turn of the lab is tried."""

FAR_MM = 60.0
"""Markers whose nearest skin is farther than this, in the middle, belong to another take."""


def quarter_turns() -> list[Float[np.ndarray, "3 3"]]:
    """The 24 rotations by quarter turns; the one that does nothing first."""
    turns = []
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        for signs in product((1.0, -1.0), repeat=3):
            R = np.zeros((3, 3))
            R[np.arange(3), order] = signs
            if np.linalg.det(R) > 0:
                turns.append(R)
    return turns


def markers_in_world(take: Markers, performance: Performance) -> Float[np.ndarray, "frames markers 3"]:
    """Markers, mm, in the performance's world: the lab turned to +Y up. The turn under which they lie on the face.

    Raises:
        BadInput: they lie on it under none.
    """
    distances = [_distance(take, performance, R) for R in quarter_turns()]
    best = int(np.argmin(distances))
    if not distances[best] < FAR_MM:
        raise BadInput("view: the markers lie nowhere near the face; give the take that it was solved from")
    return take.positions @ quarter_turns()[best].T


def _distance(take: Markers, performance: Performance, R: np.ndarray) -> float:
    """Middle distance of turned markers from the nearest vertex, mm, over some frames; infinite where none is seen."""
    seconds = min(len(take.positions) / take.rate, len(performance) / performance.rate)
    found = []
    for time in np.linspace(0, seconds, TRIED, endpoint=False):
        t, frame = int(time * performance.rate), int(time * take.rate)
        points = take.positions[frame]
        points = points[np.isfinite(points).all(axis=1)] @ R.T
        vertices = performance.T_world_face[t].apply(performance.rig.vertices(performance.weights[t]))
        if len(points):
            found.append(np.median(cKDTree(vertices).query(points)[0]))
    return float(np.median(found)) if found else np.inf
