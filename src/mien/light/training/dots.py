"""Dots of make-up on a face: found in a scan's albedo, lifted onto its surface."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from ..disk.light_scan import LightScan

DARKEST = 1e-3
"""Albedo below this is taken for this: logarithms need a floor."""
SURROUND = 2.5
"""The ring that a dot is compared with is so many times as wide as the dot."""


@dataclass(frozen=True)
class DotConfig:
    """What counts as a dot."""

    radius_mm: float = 1.5
    """Of a dot."""
    contrast: float = 0.15
    """Least difference of log albedo between a dot and its ring, both blurred: 0.15 is a tenth darker."""
    bright: bool = False
    """Dots are brighter than the skin, not darker."""
    elongated: float = 3.0
    """Greatest ratio of a dot's two curvatures: brows, lips and lids are lines, not dots."""


def find_dots(scan: LightScan, config: DotConfig = DotConfig()) -> Float[np.ndarray, "k 3"]:
    """Places of dots on the skin, rig space, mm, in no order; moles and nostrils may be among them.

    Where the patterns were lost on a dot, the skin round it says where it lies.
    """
    size = pixel_mm(scan)
    if not np.isfinite(size):
        return np.zeros((0, 3))
    sigma = config.radius_mm / size / np.sqrt(2)
    known = np.isfinite(scan.albedo) & ndimage.binary_closing(scan.known, iterations=int(np.ceil(4 * sigma)))
    grey = np.log(np.maximum(np.where(known, scan.albedo, 1.0), DARKEST))
    ring = masked_blur(grey, known, SURROUND * sigma)
    dark = np.where(known, ring - masked_blur(grey, known, sigma), -np.inf)
    dark = -dark if config.bright else dark
    reach = 2 * int(np.ceil(sigma)) + 1
    peaks = (dark == ndimage.maximum_filter(dark, reach)) & (dark > config.contrast) & known
    peaks &= ndimage.binary_erosion(known, iterations=max(round(sigma), 1))
    y, x = np.nonzero(peaks)
    places, round_ = _summits(np.where(known, dark, 0.0), y, x, config.elongated)
    where = [places[round_, 1], places[round_, 0]]
    smooth = [masked_blur(scan.points[..., i], scan.known, sigma) for i in range(3)]
    return np.stack([ndimage.map_coordinates(axis, where, order=1) for axis in smooth], 1).reshape(-1, 3)


def pixel_mm(scan: LightScan) -> float:
    """Size of the camera's pixels on the skin: the median distance between neighbours; NaN where there are none."""
    steps = np.linalg.norm(np.diff(scan.points, axis=1), axis=-1)
    steps = steps[np.isfinite(steps)]
    return float(np.median(steps)) if len(steps) else float("nan")


def masked_blur(image: Float[np.ndarray, "h w"], known: Bool[np.ndarray, "h w"], sigma: float) -> np.ndarray:
    """Gaussian mean over known pixels."""
    total = ndimage.gaussian_filter(np.where(known, image, 0.0), sigma)
    return total / np.maximum(ndimage.gaussian_filter(known.astype(float), sigma), 1e-6)


def _summits(image: np.ndarray, y: np.ndarray, x: np.ndarray, elongated: float) -> tuple[np.ndarray, np.ndarray]:
    """Tops (x, y) of the parabolas through 3 x 3 pixels, and which of them are round."""
    inside = (y > 0) & (x > 0) & (y < image.shape[0] - 1) & (x < image.shape[1] - 1)
    y, x = np.where(inside, y, 1), np.where(inside, x, 1)
    dx = (image[y, x + 1] - image[y, x - 1]) / 2
    dy = (image[y + 1, x] - image[y - 1, x]) / 2
    xx = image[y, x + 1] + image[y, x - 1] - 2 * image[y, x]
    yy = image[y + 1, x] + image[y - 1, x] - 2 * image[y, x]
    xy = (image[y + 1, x + 1] + image[y - 1, x - 1] - image[y + 1, x - 1] - image[y - 1, x + 1]) / 4
    determinant = xx * yy - xy**2
    limit = (elongated + 1) ** 2 / elongated
    sound = inside & (determinant > 0) & ((xx + yy) ** 2 < limit * determinant)
    safe = np.where(sound, determinant, 1.0)
    step = np.stack([xy * dy - yy * dx, xy * dx - xx * dy], 1) / safe[:, None]
    return np.stack([x, y], 1) + np.clip(step, -0.7, 0.7), sound
