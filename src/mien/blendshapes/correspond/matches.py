"""Skin that the rough warp puts far from its place, found by comparing patches, before the flow (sec. 4.3).

Past the paper: landmarks of raised brows or of a smile's corners may be 8 mm off, and a flow that goes from coarse to
fine does not see a mole move by several times its own width (Brox and Malik 2011). Patches are compared at every shift
within a reach, forth and back; those that agree and have no rival carry the warp along, smoothly.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Float32, Int
from scipy.ndimage import gaussian_filter
from scipy.sparse.linalg import splu

from ...image_space.layout import grid_of, sampled


@dataclass(frozen=True)
class MatchConfig:
    """How patches are compared."""

    rounds: int = 3
    """Times that what was found starts another search; 0: none at all."""
    enough_mm: float = 2.0
    """No further round once none moves the warp by more, mm."""
    pixel_mm: float = 2.0
    """Side of the pixels that are compared, mm."""
    reach_mm: float = 10.0
    """How far a patch is looked for, mm."""
    patch_mm: float = 3.5
    """Gaussian radius of a patch, mm."""
    smooth: float = 100.0
    """Weight of the found motion's bending, against 1 for a sure match."""


CAP = 2.0
"""Squared difference of a channel, in units of its strength, beyond which it is simply different."""
OVERLAP = 0.4
"""Share of a patch that both images must show."""
RIVAL = 2
"""Pixels: a shift farther than this from the best one is a rival."""
UNSURE, SURE = 0.1, 0.5
"""By what share the best shift must beat its rivals to count at all, and wholly."""
PLAIN = 0.01
"""A difference that plain skin has with itself, in the same units as `CAP`."""
RETURN_PIXELS = 1.5
"""A match forth and back ends this near to where it began."""
OFF_PIXELS = 1.5
"""A match so far off the smooth motion counts a quarter."""
ROBUST_ROUNDS = 3
STIFF = 1e-6
"""Weight of no motion where nothing is known."""

Images = Float[np.ndarray, "h w c"]


def matched_motion(
    first: Images, second: Images, config: MatchConfig, steady: Float[np.ndarray, "h w"] | None = None
) -> Float[np.ndarray, "h w 2"]:
    """Smooth motion (dx, dy) in pixels of `config.pixel_mm`: second(x + d) looks like first(x); NaN: no data.

    steady: weight of no motion at each pixel, against 1 for a sure match; None: 0.
    """
    reach = round(config.reach_mm / config.pixel_mm)
    sigma = config.patch_mm / config.pixel_mm
    there, sure = best_shifts(first, second, reach, sigma)
    back, _ = best_shifts(second, first, reach, sigma)
    returned = np.linalg.norm(there + sampled(back, grid_of(sure.shape) + there), axis=-1)
    sure = sure * (returned < RETURN_PIXELS)
    if steady is not None:
        total = sure + steady
        there = there * (sure / np.maximum(total, 1e-9))[..., None]
        sure = total
    return smooth_motion(there, sure, config.smooth)


def best_shifts(
    first: Images, second: Images, reach: int, sigma: float
) -> tuple[Float[np.ndarray, "h w 2"], Float[np.ndarray, "h w"]]:
    """The shift (dx, dy) under which each patch finds its like, between pixels, and how sure it is, 0..1."""
    shifts = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).T
    costs = shift_costs(first, second, shifts, sigma)
    best = costs.argmin(0)
    least = np.take_along_axis(costs, best[None], 0)[0]
    apart = np.abs(shifts[:, None, None] - shifts[best]).max(-1)
    rival = np.where(apart > RIVAL, costs, np.inf).min(0)
    inner = (np.abs(shifts[best]).max(-1) < reach) & np.isfinite(least) & np.isfinite(rival)
    share = 1 - (np.where(inner, least, 1.0) + PLAIN) / (np.where(inner, rival, 1.0) + PLAIN)
    sure = np.where(inner, np.clip((share - UNSURE) / (SURE - UNSURE), 0, 1), 0.0)
    return (shifts[best] + between_pixels(costs, best, reach))[..., ::-1], sure


def shift_costs(
    first: Images, second: Images, shifts: Int[np.ndarray, "s 2"], sigma: float
) -> Float32[np.ndarray, "s h w"]:
    """Mean capped squared difference of patches under each shift (dy, dx); infinite where too little is seen."""
    h, w = first.shape[:2]
    reach = int(np.abs(shifts).max())
    one = np.nan_to_num(first).astype(np.float32)
    other = np.pad(np.nan_to_num(second).astype(np.float32), ((reach, reach), (reach, reach), (0, 0)))
    seen, seen_other = np.isfinite(first[..., 0]), np.pad(np.isfinite(second[..., 0]), reach)
    costs = np.full((len(shifts), h, w), np.inf, np.float32)
    for cost, (dy, dx) in zip(costs, shifts, strict=True):
        here = slice(reach + dy, reach + dy + h), slice(reach + dx, reach + dx + w)
        both = (seen & seen_other[here]).astype(np.float32)
        differ = np.minimum((one - other[here]) ** 2, CAP).sum(-1) * both
        share = gaussian_filter(both, sigma, truncate=2.5)
        mean = gaussian_filter(differ, sigma, truncate=2.5) / np.maximum(share, OVERLAP / 10)
        np.copyto(cost, mean, where=share > OVERLAP)
    return costs


def between_pixels(
    costs: Float32[np.ndarray, "s h w"], best: Int[np.ndarray, "h w"], reach: int
) -> Float[np.ndarray, "h w 2"]:
    """How far (dy, dx) the least of a parabola through the best shift's neighbours lies from it, pixels."""
    side = 2 * reach + 1
    cube = np.where(np.isfinite(costs), costs, 1e6).reshape(side, side, *best.shape)
    rows, columns = np.indices(best.shape)
    y, x = (np.clip(i, 1, side - 2) for i in np.divmod(best, side))
    middle = cube[y, x, rows, columns]
    out = np.zeros((*best.shape, 2))
    for axis, (dy, dx) in enumerate(((1, 0), (0, 1))):
        before, after = cube[y - dy, x - dx, rows, columns], cube[y + dy, x + dx, rows, columns]
        bend = np.maximum(before - 2 * middle + after, 1e-9)
        out[..., axis] = np.clip((before - after) / (2 * bend), -0.5, 0.5)
    return out


def smooth_motion(
    motion: Float[np.ndarray, "h w 2"], sure: Float[np.ndarray, "h w"], bending: float
) -> Float[np.ndarray, "h w 2"]:
    """The motion of least bending through what is sure: min sum s |u - d|^2 + bending |Laplacian u|^2, robust."""
    height, width = sure.shape
    L = sp.kron(_second_difference(height), sp.eye(width)) + sp.kron(sp.eye(height), _second_difference(width))
    B = sp.csc_matrix(bending * (L.T @ L) + STIFF * sp.eye(sure.size))
    hold, u = np.ones(sure.shape), np.zeros_like(motion)
    for _ in range(ROBUST_ROUNDS):
        weight = (sure * hold).ravel()
        factor = splu(sp.csc_matrix(B + sp.diags(weight)), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        u = factor.solve(weight[:, None] * motion.reshape(-1, 2)).reshape(motion.shape)
        off = np.linalg.norm(u - motion, axis=-1)
        hold = 1 / (1 + (off / OFF_PIXELS) ** 2) ** 2
    return u


def _second_difference(n: int) -> sp.csr_matrix:
    """The Laplacian of a line of `n` pixels with free ends."""
    D = sp.eye(n - 1, n, k=1) - sp.eye(n - 1, n)
    return sp.csr_matrix(D.T @ D)
