"""The key lamp's soft shadow."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from .._kernels.soft_shadow import soft_shadow
from .._kernels.zbuffer import zbuffer

DISTANCE = 60.0
"""How far off the lamp stands, in radii of the mesh: far, since the light that it shadows is parallel."""


@dataclass(frozen=True)
class ShadowMap:
    """What the lamp sees (`mien._kernels.shade.soft_shadow`)."""

    lamp: Float[np.ndarray, " 3"]
    depth: Float[np.ndarray, "k k"]
    pose: Float[np.ndarray, "3 4"]
    lens: tuple[float, float, float]

    def arrives(
        self, points: Float[np.ndarray, "s 3"], normals: Float[np.ndarray, "s 3"]
    ) -> Float[np.ndarray, " s"]:
        """The share of the lamp that arrives at points in camera space, 0..1."""
        return soft_shadow(points, normals, self.lamp, self.depth, self.pose, self.lens)


def shadow_map(
    points: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"], lamp: Float[np.ndarray, " 3"], softness: float
) -> ShadowMap:
    """Look at the mesh from the lamp.

    Args:
        points: vertices, camera space, mm.
        lamp: unit direction towards the lamp.
        softness: about half the width of a shadow's edge, mm: two texels of the map, within reason.
    """
    centre = (points.min(0) + points.max(0)) / 2
    radius = max(float(np.linalg.norm(points - centre, axis=1).max()), 1e-6)
    rotation = _looking_along(-lamp)
    distance = DISTANCE * radius
    pose = np.column_stack([rotation, np.array([0, 0, distance]) - rotation @ centre])
    size = int(np.clip(4 * radius / softness, 128, 1024)) + 12
    focal = (size / 2 - 6) * np.sqrt(DISTANCE**2 - 1)
    middle = (size - 1) / 2
    seen = points @ rotation.T + pose[:, 3]
    hit, nearness = zbuffer(seen, faces, (focal, focal, middle, middle), size, size)
    depth = np.where(hit >= 0, 1 / np.where(nearness > 0, nearness, 1), 1e6)
    return ShadowMap(lamp, depth.astype(np.float32), pose, (float(focal), middle, 4 * radius / size))


def _looking_along(direction: np.ndarray) -> np.ndarray:
    """A rotation whose third row is `direction`."""
    side = np.eye(3)[np.argmin(np.abs(direction))]
    x = np.cross(side, direction)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(direction, x), direction])
