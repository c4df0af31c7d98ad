"""Landmarks of a picture as points of the depth image that goes with it."""

import numpy as np
from jaxtyping import Float, Float32

from ..camera import Camera
from .detector import Landmarks2D

ENOUGH_PIXELS = 5
"""Pixels of the nine round a landmark that must have depth."""


def lifted(depth: Float32[np.ndarray, "h w"], landmarks: Landmarks2D, camera: Camera) -> Float[np.ndarray, "478 3"]:
    """The landmarks as 3D points of the depth image (median of 3 x 3 pixels), camera space, mm; NaN without depth."""
    u, v = np.round(np.nan_to_num(landmarks.points, nan=-1.0)).astype(int).T
    inside = (u >= 1) & (v >= 1) & (u < camera.width - 1) & (v < camera.height - 1)
    u, v = np.clip(u, 1, camera.width - 2), np.clip(v, 1, camera.height - 2)
    steps = np.stack([depth[v + i, u + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]).astype(float)
    valid = (steps > 0) & inside
    some = valid.sum(0) >= ENOUGH_PIXELS
    z = np.full(len(u), np.nan)
    z[some] = np.nanmedian(np.where(valid, steps, np.nan)[:, some], axis=0)
    return camera.rays(landmarks.points) * z[:, None]
