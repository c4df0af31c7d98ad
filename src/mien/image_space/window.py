"""Sums over a broad Gaussian window round each pixel of a mask, found on blocks of pixels."""

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from .._kernels import blocks as kernel

BLOCKS = 4.0
"""Blocks a standard deviation: the window is then right to a hundredth."""


class GaussianWindow:
    """The mask's pixels and the blocks that they lie in."""

    def __init__(self, mask: Bool[np.ndarray, "h w"], sigma_px: float):
        self.rows, self.columns = np.nonzero(mask)
        self.step = max(int(sigma_px / BLOCKS), 1)
        self.shape = tuple(-(-size // self.step) for size in mask.shape)
        blurred = (self.step**2 - 1) / 12 + (self.step**2 / 6 if self.step > 1 else 0.0)
        self.sigma = np.sqrt(max(sigma_px**2 - blurred, 0.0)) / self.step

    def sums(self, values: Float[np.ndarray, "p c"]) -> Float[np.ndarray, "hh ww c"]:
        """Windowed sums of the pixels' values at the centres of the blocks, up to one factor."""
        sums = np.zeros((*self.shape, values.shape[1]))
        kernel.sum_blocks(np.ascontiguousarray(values, float), self.rows, self.columns, self.step, sums)
        return ndimage.gaussian_filter(sums, (self.sigma, self.sigma, 0), truncate=3.0)

    def at_pixels(self, blocks: Float[np.ndarray, "hh ww c"]) -> Float[np.ndarray, "p c"]:
        """Values of blocks at the pixels, by straight lines."""
        out = np.empty((len(self.rows), blocks.shape[2]))
        kernel.read_blocks(np.ascontiguousarray(blocks), self.rows, self.columns, self.step, out)
        return out
