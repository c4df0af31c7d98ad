"""Depth from normals on a grid with holes: least squares, by conjugate gradients behind a cosine transform."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy import fft, ndimage

from .._kernels._spread import cores
from ..camera import Camera
from ..errors import BadInput

STEEPEST = 0.08
"""Normals whose cosine to the line of sight is below this say nothing about depth."""
BRIDGE = 0.1
"""Weight of slopes taken over from the nearest known normal across a hole of the mask, beside a known one's 1."""
BESIDE = 0.01
"""Likewise off the mask. A mask that cuts its edges takes the cosine transform four times as many iterations as this
(80 left 0.03 mm on a real face; 30 of these are 0.06 mm off a direct solution, where 0.1 leaves 0.5), and no mask's rim
is known so well."""
ANCHOR = 1e-8
"""Weight of a depth that normals do not tell: enough for one solution."""


@dataclass(frozen=True)
class GridSolution:
    """A least-squares solution and how it was found."""

    values: Float[np.ndarray, "h w"]
    iterations: int
    converged: bool


def solve_grid(
    target: Float[np.ndarray, "h w"],
    weight: Float[np.ndarray, "h w"],
    slopes: tuple[Float[np.ndarray, "h w-1"], Float[np.ndarray, "h-1 w"]],
    slope_weights: tuple[Float[np.ndarray, "h w-1"], Float[np.ndarray, "h-1 w"]],
    tolerance: float = 3e-6,
    limit: int = 80,
) -> GridSolution:
    """min_f sum w (f - target)^2 + sum over edges s (f_next - f - slope)^2.

    The screened Poisson equation with the weights' means, which a cosine transform solves at once, is the
    preconditioner; with even weights one iteration is enough. Where nothing is asked for (holes, background) edges of
    the usual weight and no slope stand in: they cost nothing and keep the weights even.

    Raises:
        BadInput: weights that leave nothing determined.
    """
    if not (weight > 0).any() or not any((s > 0).any() for s in slope_weights):
        raise BadInput("integration: no pixel has any weight")
    shape = weight.shape
    more = [fft.next_fast_len(size) - size for size in shape]
    target, weight = (np.pad(image, ((0, more[0]), (0, more[1]))) for image in (target, weight))
    slopes, slope_weights = (
        (np.pad(across, ((0, more[0]), (0, more[1]))), np.pad(down, ((0, more[0]), (0, more[1]))))
        for across, down in (slopes, slope_weights)
    )
    empty = ~(weight > 0)
    usual = float(np.median(np.concatenate([s[s > 0] for s in slope_weights])))
    slope_weights = (
        np.where(empty[:, 1:] & empty[:, :-1], usual, slope_weights[0]),
        np.where(empty[1:] & empty[:-1], usual, slope_weights[1]),
    )
    right = weight * target - _divergence(slope_weights[0] * slopes[0], slope_weights[1] * slopes[1])

    def system(f: np.ndarray) -> np.ndarray:
        across = slope_weights[0] * np.diff(f, axis=1)
        down = slope_weights[1] * np.diff(f, axis=0)
        return weight * f - _divergence(across, down) + floor * f

    floor = 1e-9 * max(s.max() for s in slope_weights)
    inverse = _screened_poisson(weight.shape, float(weight.mean()) + floor, *(float(s.mean()) for s in slope_weights))
    start = np.where(empty, float(np.average(target, weights=weight)), target)
    found = _conjugate_gradients(system, inverse, right, start, tolerance, limit)
    return replace(found, values=found.values[: shape[0], : shape[1]])


def _divergence(across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Minus the transpose of the forward differences."""
    out = np.zeros((across.shape[0], down.shape[1]))
    out[:, :-1] += across
    out[:, 1:] -= across
    out[:-1] += down
    out[1:] -= down
    return out


def _screened_poisson(shape: tuple[int, int], screen: float, across: float, down: float) -> Callable:
    h, w = shape
    workers = cores()
    eigenvalues = screen + across * (2 - 2 * np.cos(np.pi * np.arange(w) / w))
    eigenvalues = eigenvalues[None] + down * (2 - 2 * np.cos(np.pi * np.arange(h) / h))[:, None]
    eigenvalues[0, 0] = max(eigenvalues[0, 0], 1e-12 * eigenvalues.max())

    def inverse(residual: np.ndarray) -> np.ndarray:
        spectrum = np.asarray(fft.dctn(residual, norm="ortho", workers=workers))
        return np.asarray(fft.idctn(spectrum / eigenvalues, norm="ortho", workers=workers))

    return inverse


def _conjugate_gradients(system, inverse, right, start, tolerance: float, limit: int) -> GridSolution:
    f = start
    residual = right - system(f)
    size = max(float(np.sqrt((right * inverse(right)).sum())), 1e-30)
    direction, energy = 0.0, 1.0
    for iteration in range(limit):
        conditioned = inverse(residual)
        fresh = float((residual * conditioned).sum())
        if np.sqrt(max(fresh, 0.0)) <= tolerance * size:
            return GridSolution(f, iteration, True)
        direction = conditioned + (fresh / energy) * direction
        moved = system(direction)
        step = fresh / float((direction * moved).sum())
        f = f + step * direction
        residual = residual - step * moved
        energy = fresh
    return GridSolution(f, limit, False)


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
