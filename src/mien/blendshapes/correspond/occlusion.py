"""What one scan shows and the other cannot: inside of the mouth, eyeballs, holes (Casas et al. 2016, sec. 4.3)."""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from PIL import Image, ImageDraw
from scipy.ndimage import binary_dilation, binary_fill_holes, find_objects, grey_opening, label, maximum_filter

from ...landmarks.detector import LOOPS
from ..cylinder_map import CYLINDER, HALF_ARC_MM, CylinderMap, filled

OPENINGS = ("lips_inner", "eye_left", "eye_right")
"""Loops of landmarks round what is no skin."""
RIM_MM = 0.7
"""The masks reach so far beyond the loops."""
LEAST_KNOWN = 0.5
"""Of a loop at least this share must be known: beside a mouth wide open some landmarks fall through."""
RIM_REACH_MM, BEHIND_MM = 2.5, 4.0
"""What lies so near to a point of the lips and is so much farther in is teeth or tongue: no lip is as steep."""

WIRE_MM, BEFORE_MM = 8.0, 2.5
"""What is thinner than this and stands so far before the face is no skin, if ..."""
WIDE_MM = 30.0
"""... it is wider than this, as a lens is. Some noses' ridges and wings stand out as far."""
SIDE_DEG = 88.0


def openings(map_: CylinderMap, pixels: Float[np.ndarray, "478 2"]) -> Bool[np.ndarray, "h w"]:
    """Pixels inside the lips and lids, as the landmarks have them, and what is seen behind the lips' rims."""
    mask = behind_lips(map_, pixels)
    for loop in OPENINGS:
        mask |= inside_loop(loop, pixels, map_.layout.shape)
    mask = np.asarray(binary_fill_holes(mask))
    return binary_dilation(mask, iterations=max(1, round(RIM_MM / map_.layout.pixel_mm)))


def behind_lips(map_: CylinderMap, pixels: Float[np.ndarray, "478 2"]) -> Bool[np.ndarray, "h w"]:
    """Teeth and tongue beside the inner lips' loop: where landmarks fell through, it cuts corners."""
    radius = from_axis(map_)
    side = 1 + 2 * round(RIM_REACH_MM / map_.layout.pixel_mm)
    nearby = maximum_filter(np.where(map_.known, radius, -np.inf), side)
    return map_.known & (nearby - radius > BEHIND_MM) & outer_lips(pixels, map_.layout.shape)


def from_axis(map_: CylinderMap) -> Float[np.ndarray, "h w"]:
    """Distance of each pixel's point from the cylinder's axis, mm; NaN where there is none."""
    return np.hypot(map_.positions[..., 0] - CYLINDER.x, map_.positions[..., 2] - CYLINDER.z)


def outer_lips(pixels: Float[np.ndarray, "478 2"], shape: tuple[int, int]) -> Bool[np.ndarray, "h w"]:
    """Pixels of lips and mouth."""
    return inside_loop("lips_outer", pixels, shape)


def inside_loop(loop: str, pixels: Float[np.ndarray, "478 2"], shape: tuple[int, int]) -> Bool[np.ndarray, "h w"]:
    """Pixels inside a loop of landmarks, of which some may be missing; none where most are."""
    corners = pixels[list(LOOPS[loop])]
    known = np.isfinite(corners).all(1)
    return polygon(corners[known], shape) if known.mean() > LEAST_KNOWN else np.zeros(shape, bool)


def wires(map_: CylinderMap, pixels: Float[np.ndarray, "478 2"]) -> Bool[np.ndarray, "h w"]:
    """Thin things before the face, such as the rims of glasses: what an opening of the surface takes away.

    Not round the mouth, whose lips are thin, nor beyond `SIDE_DEG` from the front, where ears are.
    """
    layout, rows = map_.layout, map_.layout.shape[0]
    whole = filled(from_axis(map_)[..., None])[..., 0]
    side = max(3, round(WIRE_MM / layout.pixel_mm))
    before = whole - grey_opening(whole, size=(side, side)) > BEFORE_MM
    across = (np.arange(layout.shape[1]) * layout.pixel_mm - HALF_ARC_MM) / CYLINDER.radius
    before &= np.abs(across) < np.radians(SIDE_DEG)
    lips = pixels[list(LOOPS["lips_outer"])]
    if np.isfinite(lips).all():
        reach = round(WIRE_MM / layout.pixel_mm)
        top, bottom = np.clip([lips[:, 1].min() - reach, lips[:, 1].max() + reach], 0, rows).astype(int)
        before[top:bottom] = False
    parts: Any = label(before)
    wide = [part[1].stop - part[1].start > WIDE_MM / layout.pixel_mm for part in find_objects(parts[0])]
    kept = np.isin(parts[0], 1 + np.flatnonzero(wide))
    return binary_dilation(kept, iterations=max(1, round(RIM_MM / layout.pixel_mm)))


def without(map_: CylinderMap, gone: Bool[np.ndarray, "h w"]) -> CylinderMap:
    """The map as if some pixels had not been seen."""
    nothing = np.float32(np.nan)
    positions, colors = (np.where(gone[..., None], nothing, image) for image in (map_.positions, map_.colors))
    return replace(map_, positions=positions, colors=colors, confidence=np.where(gone, np.float32(0), map_.confidence))


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
