"""Depth from normals on a grid with holes: least squares in the logarithm of depth, whose slopes normals tell."""

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from ..camera import Camera
from ..errors import BadInput
from ..solve.grid import solve_grid

STEEPEST = 0.08
"""Normals whose cosine to the line of sight is below this say nothing about depth."""
BRIDGE = 0.1
"""Weight of slopes taken over from the nearest known normal across a hole of the mask, beside a known one's 1."""
BESIDE = 0.01
"""Likewise off the mask, so that pieces of it that do not touch stand about where they should."""
ANCHOR = 1e-8
"""Weight of a depth that normals do not tell: enough for one solution."""


def log_slopes(
    normals: Float[np.ndarray, "h w 3"], camera: Camera, rays: Float[np.ndarray, "h w 3"]
) -> Float[np.ndarray, "h w 2"]:
    """d log z / d(x, y), a pixel, of the surface with these normals (camera space) under perspective.

    A point is z (x', y', 1); its tangents are normal to n: with q = log z, q_x (n . ray) + n_x / fx = 0.
    """
    toward = (normals * rays).sum(-1)
    focal = np.array([camera.fx, camera.fy])
    with np.errstate(invalid="ignore", divide="ignore"):
        slopes = -normals[..., :2] / focal / toward[..., None]
    cosine = np.abs(toward) / np.linalg.norm(rays, axis=-1)
    return np.where((cosine > STEEPEST)[..., None], slopes, np.nan)


def on_edges(
    slopes: Float[np.ndarray, "h w 2"], weight: Float[np.ndarray, "h w"]
) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Slopes and weights between neighbours: means of the two ends, nothing where an end is unknown."""
    known = np.asarray(np.all(np.isfinite(slopes), axis=-1))
    filled, kept = np.where(known[..., None], slopes, 0.0), np.where(known, weight, 0.0)
    across = (filled[:, :-1, 0] + filled[:, 1:, 0]) / 2
    down = (filled[:-1, :, 1] + filled[1:, :, 1]) / 2
    return (across, down), (np.minimum(kept[:, :-1], kept[:, 1:]), np.minimum(kept[:-1], kept[1:]))


def integrate(
    normals: Float[np.ndarray, "h w 3"],
    camera: Camera,
    rays: Float[np.ndarray, "h w 3"],
    mask: Bool[np.ndarray, "h w"],
    mean_z: float,
) -> Float[np.ndarray, "h w"]:
    """Depth, mm, of the surface with these normals, at a mean depth that normals cannot tell; NaN off the mask.

    Where a normal is unknown the nearest one stands in for it.

    Raises:
        BadInput: no normal within the mask.
    """
    slopes = log_slopes(np.where(mask[..., None], normals, np.nan), camera, rays)
    known = mask & np.isfinite(slopes).all(-1)
    if not known.any():
        raise BadInput("integration: no normal is known")
    steps, weights = on_edges(extended(slopes, known), np.where(known, 1.0, np.where(mask, BRIDGE, BESIDE)))
    solved = solve_grid(np.zeros(mask.shape), np.full(mask.shape, ANCHOR), steps, weights)
    log_z = np.where(mask, solved.values, np.nan)
    return mean_z * np.exp(log_z - np.nanmean(log_z))


def extended(values: Float[np.ndarray, "h w c"], known: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w c"]:
    """Every other pixel takes after the nearest known one."""
    nearest = np.asarray(ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True))
    return values[nearest[0], nearest[1]]
