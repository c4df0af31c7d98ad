"""Textures that move."""

import numpy as np
from scipy import ndimage

from mien.flow import FlowConfig

N = 96


CLEAN = FlowConfig(brightness=1.0, smoothness=0.5, presmooth=0.3, warps=10, tolerance=0.002)
"""For images without noise and change of light."""


class Texture:
    """Smooth noise that can be read anywhere: order-5 splines over periodic noise."""

    def __init__(self, seed, sigma=2.0, size=160):
        noise = np.random.default_rng(seed).standard_normal((size, size))
        noise = ndimage.gaussian_filter(noise, sigma, mode="wrap") + ndimage.gaussian_filter(
            noise, 4 * sigma, mode="wrap"
        )
        self.spline = ndimage.spline_filter(noise / noise.std(), 5, mode="grid-wrap")

    def __call__(self, x, y):
        return ndimage.map_coordinates(self.spline, [y + 32, x + 32], order=5, prefilter=False, mode="grid-wrap")


def grid(h=N, w=N):
    y, x = np.mgrid[:h, :w].astype(float)
    return x, y


def pair(texture, flow):
    """Source and target with target(p + flow(p)) = source(p)."""
    x, y = grid(*flow.shape[:2])
    return texture(x + flow[..., 0], y + flow[..., 1]), texture(x, y)


def sine(amplitude, length):
    x, y = grid()
    u = amplitude * np.sin(2 * np.pi * y / length)
    return np.stack([u, amplitude * np.sin(2 * np.pi * x / length)], -1)


def shift(dx, dy, h=N, w=N):
    return np.broadcast_to(np.array([dx, dy], float), (h, w, 2))
