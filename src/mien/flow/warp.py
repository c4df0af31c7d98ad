"""Reading images between pixels, and image pyramids. Pixel centres are at integers."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Float32
from scipy import ndimage

PREFILTER = 0.6
"""Gaussian before a reduction by s: this times sqrt(1 / s^2 - 1) pixels, which leaves next to no aliasing."""
SPLINE_REACH = 8
"""Pixels after which a border's influence on spline coefficients is gone (0.27^8 < 1e-4)."""
HOLE = 1e-3
"""A smoothed weight below which a pixel has no value of its own and is filled from the coarser level."""


def warp(
    image: Float[np.ndarray, "h w *c"], flow: Float[np.ndarray, "h w 2"], order: int = 3
) -> Float[np.ndarray, "h w *c"]:
    """`image` read at (x, y) + flow (dx, dy), pixels; NaN where that lies outside.

    order: 3 for cubic B-splines, 1 for bilinear (which keeps NaN pixels of the image to themselves).
    """
    h, w = image.shape[:2]
    y, x = np.mgrid[:h, :w]
    x, y = x + flow[..., 0], y + flow[..., 1]
    outside = (x < 0) | (x > w - 1) | (y < 0) | (y > h - 1)
    flat = image.reshape(h, w, -1)
    channels = [ndimage.map_coordinates(flat[..., c], [y, x], order=order, mode="mirror") for c in range(flat.shape[2])]
    channels = [np.where(outside, np.nan, channel) for channel in channels]
    return np.stack(channels, -1).reshape(image.shape)


def spline_coefficients(image: Float32[np.ndarray, "h w c"]) -> Float32[np.ndarray, "c hhww"]:
    """Cubic B-spline coefficients (c, (h + 3) * (w + 3)), one entry of frame before and two after.

    The image is continued by its point reflection at the border's pixels, so that slopes hold there.
    """
    reach = min(SPLINE_REACH, *(n - 1 for n in image.shape[:2]))
    wide = np.pad(image, ((reach, reach), (reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    channels = [ndimage.spline_filter(wide[..., c], 3, mode="mirror") for c in range(image.shape[2])]
    inner = slice(reach - 1, 2 - reach)
    return np.stack([channel[inner, inner].ravel() for channel in channels], dtype=np.float32)


def smooth(image: Float32[np.ndarray, "h w c"], sigma: float, odd: bool = True) -> Float32[np.ndarray, "h w c"]:
    """Gaussian blur of `sigma` pixels. odd: beyond the border goes on the point reflection, else the mirror image."""
    h, w = image.shape[:2]
    return _apply(_gaussian(h, h, sigma, odd), _gaussian(w, w, sigma, odd), image)


def shrink(
    image: Float32[np.ndarray, "h w c"], shape: tuple[int, int], odd: bool = True
) -> Float32[np.ndarray, "hh ww c"]:
    """The image on fewer pixels (height, width), prefiltered; the two images' outer borders coincide."""
    sizes = zip(image.shape[:2], shape, strict=True)
    rows, columns = (_gaussian(n, m, PREFILTER * np.sqrt(max((n / m) ** 2 - 1, 0.1)), odd) for n, m in sizes)
    return _apply(rows, columns, image)


def enlarge(image: Float32[np.ndarray, "h w c"], shape: tuple[int, int]) -> Float32[np.ndarray, "hh ww c"]:
    """The image on more pixels (height, width), bicubic; the two images' outer borders coincide."""
    rows, columns = (_resampling(n, m, 2, _catmull_rom) for n, m in zip(image.shape[:2], shape, strict=True))
    return _apply(rows, columns, image)


def splat(
    places: Float[np.ndarray, "k 2"], values: Float[np.ndarray, "k c"], shape: tuple[int, ...]
) -> Float[np.ndarray, "h w c"]:
    """Values at points (x, y) handed out to the four pixels round each, bilinear shares, and added up."""
    h, w = shape
    image = np.zeros((h * w, values.shape[1]))
    corner = np.clip(places.astype(int), 0, [w - 2, h - 2])
    part = places - corner
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        share = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
        np.add.at(image, (corner[:, 1] + dy) * w + corner[:, 0] + dx, share[:, None] * values)
    return image.reshape(h, w, -1)


@dataclass(frozen=True)
class Level:
    """Two images at one scale."""

    source: Float32[np.ndarray, "h w c"]
    target: Float32[np.ndarray, "h w c"]
    source_weight: Float32[np.ndarray, "h w"]
    """How far a pixel holds data, 0..1."""
    target_weight: Float32[np.ndarray, "h w"]
    scale: tuple[float, float] = (1.0, 1.0)
    """Pixels here a pixel of the finest level, along x and along y."""


def pyramid(
    source: Float[np.ndarray, "h w c"],
    target: Float[np.ndarray, "h w c"],
    source_weight: Float[np.ndarray, "h w"],
    target_weight: Float[np.ndarray, "h w"],
    factor: float = 0.5,
    coarsest: int = 8,
    presmooth: float = 0.0,
) -> list[Level]:
    """Two images at every scale, the finest first, each level `factor` times the last, down to `coarsest` pixels.

    A pixel of weight 0 counts for nothing, whatever its value: averages are of the others alone, and holes
    are filled smoothly from the coarser levels. presmooth: Gaussian on the finest level, pixels.
    """
    shapes = list(_shapes((source.shape[0], source.shape[1]), factor, coarsest))
    sources = _reduced(source, source_weight, shapes, presmooth)
    targets = _reduced(target, target_weight, shapes, presmooth)
    h, w = shapes[0]
    return [
        Level(s, t, sw, tw, (shape[1] / w, shape[0] / h))
        for shape, (s, sw), (t, tw) in zip(shapes, sources, targets, strict=True)
    ]


def _shapes(shape: tuple[int, int], factor: float, coarsest: int) -> Iterator[tuple[int, int]]:
    """Heights and even widths, finest first."""
    while True:
        yield shape
        smaller = round(shape[0] * factor), 2 * round(shape[1] * factor / 2)
        if min(smaller) < max(coarsest, 4) or smaller == shape:
            return
        shape = smaller


def _reduced(
    image: np.ndarray, weight: np.ndarray, shapes: list[tuple[int, int]], presmooth: float
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Images and weights at every shape, by normalised convolution, holes filled."""
    full = bool((weight == 1).all())
    weight = weight[..., None].astype(np.float32)
    sums = np.where(weight > 0, image, 0).astype(np.float32) * weight
    blur = (lambda a: smooth(a, presmooth, full)) if presmooth > 0 else (lambda a: a)
    levels = [(blur(sums), np.ones_like(weight) if full else blur(weight), weight)]
    for shape in shapes[1:]:
        sums = shrink(sums, shape, full)
        weight = np.ones((*shape, 1), np.float32) if full else shrink(weight, shape, full)
        levels.append((sums, weight, weight))
    result = []
    for sums, spread, weight in reversed(levels):
        if full:
            values = sums
        elif result:
            values = np.where(spread > HOLE, sums / np.maximum(spread, HOLE), enlarge(result[-1][0], sums.shape[:2]))
        else:
            mean = sums.sum((0, 1)) / max(spread.sum(), HOLE)
            values = np.where(spread > HOLE, sums / np.maximum(spread, HOLE), mean.astype(np.float32))
        result.append((np.ascontiguousarray(values), np.ascontiguousarray(weight[..., 0])))
    return result[::-1]


def _gaussian(n: int, m: int, sigma: float, odd: bool) -> sp.csr_matrix:
    return _resampling(n, m, 1 + int(np.ceil(3.5 * sigma)), lambda d: np.exp(-0.5 * (d / sigma) ** 2), odd)


def _catmull_rom(d: np.ndarray) -> np.ndarray:
    d = np.abs(d)
    far = np.where(d < 2, -0.5 * d**3 + 2.5 * d**2 - 4 * d + 2, 0)
    return np.where(d < 1, 1.5 * d**3 - 2.5 * d**2 + 1, far)


def _resampling(n: int, m: int, radius: int, kernel, odd: bool = True) -> sp.csr_matrix:
    """Matrix (m, n) from n pixels to m over the same length, rows summing to 1.

    What it takes from beyond the border is the point reflection at the border's pixel (odd) or the mirror image.
    """
    centres = (np.arange(m) + 0.5) * (n / m) - 0.5
    columns = np.floor(centres).astype(int)[:, None] + np.arange(1 - radius, radius + 1)
    weights = kernel(columns - centres[:, None])
    weights = (weights / weights.sum(1, keepdims=True)).ravel()
    rows, columns = np.repeat(np.arange(m), columns.shape[1]), columns.ravel()
    border = np.clip(columns, 0, n - 1)
    beyond = border != columns
    inside = np.clip(2 * border - columns, 0, n - 1)
    if odd:
        weights = np.concatenate([np.where(beyond, -weights, weights), 2 * weights[beyond]])
        rows, inside = np.concatenate([rows, rows[beyond]]), np.concatenate([inside, border[beyond]])
    return sp.csr_matrix((weights.astype(np.float32), (rows, inside)), shape=(m, n))


def _apply(rows: sp.csr_matrix, columns: sp.csr_matrix, image: np.ndarray) -> np.ndarray:
    h, w, c = image.shape
    tall = (rows @ image.reshape(h, w * c)).reshape(-1, w, c).transpose(1, 0, 2)
    wide = (columns @ np.ascontiguousarray(tall).reshape(w, -1)).reshape(-1, tall.shape[1], c)
    return np.ascontiguousarray(wide.transpose(1, 0, 2))
