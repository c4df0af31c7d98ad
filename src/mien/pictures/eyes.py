"""Eyes that are known by their shape."""

import numpy as np
from jaxtyping import Bool, Float

from ..mesh import Mesh, connected_parts


def eyeballs(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Vertices of parts that are round and of an eye's size beside the whole: they shine, since eyes are wet.

    A part is a connected piece of 30 vertices or more; round means that its vertices keep within 2.5 % (rms) of a
    sphere, and its radius is between a fiftieth and a fifth of the mesh's.
    """
    found = np.zeros(len(mesh.vertices), dtype=bool)
    whole = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) / 2
    part = connected_parts(mesh.faces, len(mesh.vertices))
    order = np.argsort(part, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(part[order])) + 1):
        if len(members) >= 30:
            found[members] = _is_eyeball(mesh.vertices[members], whole)
    return found


def _is_eyeball(vertices: Float[np.ndarray, "k 3"], whole: float) -> bool:
    points = vertices - vertices.mean(0)
    if np.ptp(points, axis=0).max() > 0.45 * whole:
        return False
    solved = np.linalg.lstsq(np.c_[2 * points, np.ones(len(points))], (points**2).sum(1), rcond=None)[0]
    radius = float(np.sqrt(max(solved[3] + solved[:3] @ solved[:3], 0.0)))
    off = np.linalg.norm(points - solved[:3], axis=1) - radius
    return bool(0.02 * whole < radius < 0.2 * whole and np.sqrt(np.mean(off**2)) < 0.025 * radius)
