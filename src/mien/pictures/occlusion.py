"""How much of the sky each vertex sees: soft ambient occlusion without noise, by fixed rays."""

import numpy as np
from jaxtyping import Float

from ..mesh import Mesh, adjacency, vertex_normals
from .raycast import RayCaster

LIFT = 1e-4
"""How far rays start off the surface, as a share of the mesh's diagonal: more than Embree's float32 rounds away."""


def sky_directions(count: int) -> Float[np.ndarray, "count 3"]:
    """`count` unit directions spread evenly over the sphere (a Fibonacci spiral)."""
    i = np.arange(count) + 0.5
    z = 1 - 2 * i / count
    turn = np.pi * (1 + 5**0.5) * i
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(turn), z, r * np.sin(turn)], 1)


def ambient_occlusion(mesh: Mesh, rays: int = 64, reach: float = np.inf) -> Float[np.ndarray, " n"]:
    """The cosine-weighted share of the sky that each vertex sees, 0..1; 1 in the open.

    The same `rays` directions over the whole sphere serve every vertex (each uses those above its tangent plane), and
    the result is averaged once over neighbours, so that it varies smoothly over the surface and over time.

    Args:
        rays: directions over the sphere.
        reach: what is farther than this (mm) does not occlude.
    """
    normals = vertex_normals(mesh.vertices, mesh.faces)
    lift = LIFT * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    caster = RayCaster(mesh)
    seen, whole = np.zeros(len(normals)), np.zeros(len(normals))
    for direction in sky_directions(rays):
        cosine = normals @ direction
        up = np.flatnonzero(cosine > 0.02)
        start = mesh.vertices[up] + lift * (normals[up] + direction)
        clear = ~caster.occluded(start, direction[None], reach)
        seen[up] += cosine[up] * clear
        whole[up] += cosine[up]
    return _smoothed(np.where(whole > 0, seen / np.where(whole > 0, whole, 1), 1.0), mesh)


def _smoothed(values: np.ndarray, mesh: Mesh) -> np.ndarray:
    A = adjacency(mesh.faces, len(values))
    degree = np.asarray(A.sum(axis=1)).ravel()
    return np.where(degree > 0, 0.5 * values + 0.5 * (A @ values) / np.maximum(degree, 1), values)
