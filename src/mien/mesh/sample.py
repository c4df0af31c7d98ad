"""Points spread over a surface, and values carried from one surface to another."""

import numpy as np
from jaxtyping import Float, Int

from mien.errors import BadInput

from .closest import closest_point
from .mesh import Attachment, Mesh
from .operators import face_areas

CANDIDATES = 8
"""Random points drawn a point kept by `blue_noise`: more are more even and slower."""


def farthest_points(points: Float[np.ndarray, "n d"], count: int, start: int = 0) -> Int[np.ndarray, " count"]:
    """Indices of `count` points, each the farthest from all before it, `start` first (Gonzalez 1985).

    Raises:
        BadInput: more points asked for than there are.
    """
    if not 0 < count <= len(points):
        raise BadInput(f"farthest points: {count} asked for of {len(points)}; ask for 1 to {len(points)}")
    chosen = np.empty(count, np.int64)
    chosen[0] = start
    distance = ((points - points[start]) ** 2).sum(1)
    for i in range(1, count):
        chosen[i] = distance.argmax()
        np.minimum(distance, ((points - points[chosen[i]]) ** 2).sum(1), out=distance)
    return chosen


def random_points(mesh: Mesh, count: int, seed: int = 0) -> Attachment:
    """Points spread at random, evenly by area."""
    rng = np.random.default_rng(seed)
    areas = face_areas(mesh.vertices, mesh.faces)
    faces = rng.choice(len(areas), count, p=areas / areas.sum())
    root, share = np.sqrt(rng.random(count)), rng.random(count)
    return Attachment(faces, np.stack([1 - root, root * (1 - share), root * share], 1))


def blue_noise(mesh: Mesh, count: int, seed: int = 0) -> Attachment:
    """Points spread evenly at random, none close to another: the farthest of many random ones (straight distances)."""
    many = random_points(mesh, CANDIDATES * count, seed)
    keep = farthest_points(many.points(mesh), count)
    return Attachment(many.faces[keep], many.barycentric[keep])


def transfer(source: Mesh, values: Float[np.ndarray, "n *c"], points: Float[np.ndarray, "p 3"]) -> np.ndarray:
    """Vertex values of `source` at the surface points closest to `points`: (p, *c)."""
    D = closest_point(source, points).attachment().matrix(source)
    return (D @ values.reshape(len(values), -1)).reshape(len(points), *values.shape[1:])
