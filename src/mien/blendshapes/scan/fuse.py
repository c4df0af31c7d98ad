"""Many frames on one map: a robust average a pixel, smoothed without blurring its edges (Casas et al. 2016, sec. 3)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32, Int
from scipy.ndimage import binary_opening, gaussian_filter, label

from ...camera import Camera
from ...depth import bilateral
from ...mesh import Mesh, SurfaceImage
from ..cylinder_map import CYLINDER, CylinderLayout, outermost_first
from .frames import PlacedFrame, frame_mesh

GRAZING = 0.25
"""Depth seen at a smaller cosine than this does not count."""
OUTLIER_MM = 2.0
"""A frame this far from the others counts a quarter at that pixel."""
ROUNDS = 4
"""Of the robust average: weights have settled."""


@dataclass(frozen=True)
class FuseConfig:
    """The average over frames and the filter on it."""

    robust: bool = True
    """Frames that disagree at a pixel lose weight there; off: the plain mean."""
    smooth_mm: float = 2.5
    """Half width of the bilateral filter on the map, mm; 0: none."""
    edge_mm: float = 1.2
    """The filter does not reach over steps of more than three times this, mm."""
    sure_frames: float = 6.0
    """A pixel seen straight on by so many frames has a confidence of 1/2."""
    hole_mm: float = 14.0
    """Holes up to this wide, enclosed by surface, are filled smoothly, with next to no confidence; 0: none."""


@dataclass(frozen=True)
class RadiusMap:
    """The average surface: distance from the axis."""

    radii: Float32[np.ndarray, "h w"]
    """mm; NaN where there is none."""
    confidence: Float32[np.ndarray, "h w"]
    """0..1."""
    deviation_mm: float
    """How far frames are from their average, median over the map, mm."""


def radius_of_frame(
    placed: PlacedFrame, camera: Camera, layout: CylinderLayout
) -> tuple[Float32[np.ndarray, "h w"], Float32[np.ndarray, "h w"]]:
    """One frame's distance from the axis at each pixel (NaN: none), and the cosine at which it was seen there."""
    mesh, cosines = frame_mesh(placed, camera)
    keep = cosines > GRAZING
    weights = np.zeros(len(mesh.vertices))
    np.maximum.at(weights, mesh.faces[keep].ravel(), np.repeat(cosines[keep], 3))
    places, faces = outermost_first(Mesh(mesh.vertices, mesh.faces[keep]), layout)
    image = SurfaceImage(places, faces, layout.shape)
    radius = np.hypot(mesh.vertices[:, 0] - CYLINDER.x, mesh.vertices[:, 2] - CYLINDER.z)
    drawn = image.draw(np.stack([radius, weights], 1)).astype(np.float32)
    return drawn[..., 0], np.nan_to_num(drawn[..., 1])


def fuse(
    radii: Float32[np.ndarray, "frames h w"],
    cosines: Float32[np.ndarray, "frames h w"],
    layout: CylinderLayout,
    config: FuseConfig = FuseConfig(),
) -> RadiusMap:
    """The frames' average at each pixel: weighted by angle, outliers out, then the bilateral filter."""  # fmt: skip
    known = np.isfinite(radii)
    values = np.where(known, radii, 0)
    sight = cosines**2 * known
    weights = sight
    mean = _mean(values, weights)
    for _ in range(ROUNDS if config.robust else 0):
        off = np.abs(values - mean)
        weights = sight / (1 + (off / OUTLIER_MM) ** 2) ** 2
        mean = _mean(values, weights)
    total = weights.sum(0)
    spread = np.sqrt((weights * (values - mean) ** 2).sum(0) / np.maximum(total, 1e-6))
    there = largest_piece(binary_opening(total > 0.2))
    confidence = np.where(there, total / (total + config.sure_frames) * np.exp(-((spread / 3.0) ** 2)), 0)
    middle = float(np.median(spread[there])) if there.any() else 0.0
    smooth = smoothed(np.where(there, mean, np.nan), layout, config)
    closed = fill_holes(smooth, config.hole_mm / layout.pixel_mm)
    confidence = np.where(np.isnan(smooth) & np.isfinite(closed), 0.02, confidence)
    return RadiusMap(closed.astype(np.float32), confidence.astype(np.float32), middle)


def largest_piece(mask: Bool[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """The largest connected part: the head without its shoulders."""
    parts = labelled(mask)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return parts == sizes.argmax() if sizes.any() else mask


def labelled(mask: Bool[np.ndarray, "h w"]) -> Int[np.ndarray, "h w"]:
    """Connected parts of a mask, numbered from 1; 0 outside."""
    found: Any = label(mask)
    return found[0]


def smoothed(radii: np.ndarray, layout: CylinderLayout, config: FuseConfig) -> np.ndarray:
    """The bilateral filter on the map (sec. 3)."""
    reach = round(config.smooth_mm / layout.pixel_mm)
    if reach < 1:
        return radii
    calm = bilateral(np.nan_to_num(radii).astype(np.float32), reach, config.edge_mm)
    return np.where(np.isnan(radii), np.nan, calm)


def fill_holes(radii: np.ndarray, widest: float) -> np.ndarray:
    """Small enclosed holes filled from what is round them, the nearer the more; `widest` in pixels."""
    gone = np.isnan(radii)
    parts = labelled(gone)
    areas = np.bincount(parts.ravel())
    rim = np.unique(np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]]))
    small = areas <= widest**2
    small[rim] = False
    small[0] = False
    hole = small[parts]
    if not hole.any():
        return radii
    out = radii.copy()
    for sigma in (1.0, 2.0, 4.0, 8.0, 16.0):
        open_ = np.isnan(out) & hole
        if not open_.any():
            break
        known = np.isfinite(radii)
        share = gaussian_filter(known.astype(float), sigma)
        values = gaussian_filter(np.where(known, radii, 0.0), sigma) / np.maximum(share, 1e-9)
        out = np.where(open_ & (share > 0.05), values, out)
    return out


def _mean(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return (weights * values).sum(0) / np.maximum(weights.sum(0), 1e-6)
