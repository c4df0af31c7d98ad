"""What one scan shows and the other cannot: inside of the mouth, eyeballs, holes (Casas et al. 2016, sec. 4.3)."""

import numpy as np
from jaxtyping import Bool, Float
from PIL import Image, ImageDraw
from scipy.ndimage import binary_dilation

from ...landmarks.detector import LOOPS
from ..cylinder_map import CylinderMap

OPENINGS = ("lips_inner", "eye_left", "eye_right")
"""Loops of landmarks round what is no skin."""
RIM_MM = 0.7
"""The masks reach so far beyond the loops."""


def openings(map_: CylinderMap, pixels: Float[np.ndarray, "478 2"]) -> Bool[np.ndarray, "h w"]:
    """Pixels inside the lips and lids, as the landmarks have them."""
    mask = np.zeros(map_.layout.shape, bool)
    for loop in OPENINGS:
        corners = pixels[list(LOOPS[loop])]
        if np.isfinite(corners).all():
            mask |= polygon(corners, map_.layout.shape)
    return binary_dilation(mask, iterations=max(1, round(RIM_MM / map_.layout.pixel_mm)))


def skin(
    map_: CylinderMap, pixels: Float[np.ndarray, "478 2"], painted: Bool[np.ndarray, "h w"] | None = None
) -> Bool[np.ndarray, "h w"]:
    """Pixels that may be matched: surface, outside mouth and eyes, and not painted out by hand."""
    free = map_.known & ~openings(map_, pixels)
    return free if painted is None else free & ~painted


def polygon(corners: Float[np.ndarray, "k 2"], shape: tuple[int, int]) -> Bool[np.ndarray, "h w"]:
    """Pixels inside a closed line (x, y)."""
    picture = Image.new("1", (shape[1], shape[0]))
    if len(corners) > 2:
        ImageDraw.Draw(picture).polygon([(float(x), float(y)) for x, y in corners], fill=1, outline=1)
    return np.asarray(picture, bool).copy()
