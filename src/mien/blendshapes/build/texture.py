"""Textures of all expressions in the artist mesh's UV space (Casas et al. 2016, sec. 5.1)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, UInt8
from scipy.ndimage import distance_transform_edt, gaussian_filter

from ...image_space.layout import grid_of, sampled
from ...mesh import Mesh, SurfaceImage
from ..correspond.dense import SkinWarp
from ..cylinder_map import CylinderMap, filled
from .artist_mesh import ON_MAP_MM, SURE

FEATHER = 8.0
"""Texels over which a captured texture fades in from its rim."""
DARK = 0.02
"""Colours are divided by no less than this."""
TONES = (1.0, 4.0, 16.0, 64.0)
"""Blurs, in `COARSE` texels, by which the tone of what was captured is carried over what was not, the nearest first."""
COARSE = 4
"""Tones are carried on every so many texels."""


@dataclass(frozen=True)
class TexelGrid:
    """Where each texel of a mesh's UV space is in the neutral's map."""

    pixels: Float[np.ndarray, "h w 2"]
    """Map pixels (x, y); NaN off the UV islands."""
    shown: Bool[np.ndarray, "h w"]
    """Texels of skin that the neutral's map shows."""
    own: Float[np.ndarray, "h w 3"]
    """The mesh's own vertex colours, sRGB in 0..1; NaN off the islands."""


def texel_grid(mesh: Mesh, shown: Bool[np.ndarray, " n"], neutral: CylinderMap, size: int) -> TexelGrid:
    """Lay the mesh's UV islands out on `size` texels a side.

    Raises:
        ValueError: a mesh without uv.
    """
    if mesh.uv is None:
        raise ValueError("uv: the artist mesh needs texture coordinates")
    corners = mesh.faces if mesh.uv_faces is None else mesh.uv_faces
    places = np.stack([mesh.uv[:, 0] * size - 0.5, (1 - mesh.uv[:, 1]) * size - 0.5], 1)
    image = SurfaceImage(places, corners, (size, size))
    on = image.mask
    vertices, weights = mesh.faces[image.faces[on]], image.barycentric[on]
    points = np.einsum("tc,tcd->td", weights, mesh.vertices[vertices])
    pixels = neutral.layout.pixels(points)
    there, _ = neutral.at(pixels)
    sure = sampled(neutral.confidence.astype(float), pixels)[:, 0] > SURE
    near = np.nan_to_num(np.linalg.norm(there - points, axis=1), nan=np.inf) < ON_MAP_MM
    seen = near & sure & ((weights * shown[vertices]).sum(1) > 0.5)
    colours = np.full((len(mesh.vertices), 3), 0.5) if mesh.colors is None else mesh.colors
    return TexelGrid(
        pixels=_scattered(pixels, on, np.nan),
        shown=_scattered(seen, on, False),
        own=_scattered(np.einsum("tc,tcd->td", weights, colours[vertices]), on, np.nan),
    )


def neutral_texture(grid: TexelGrid, neutral: CylinderMap) -> Float[np.ndarray, "h w 3"]:
    """The neutral's colours; where the scan shows nothing the mesh's own, toned as the skin beside; gutters filled."""
    _, colors = neutral.at(np.nan_to_num(grid.pixels, nan=-9.0))
    seen = grid.shown & np.isfinite(colors[..., 0])
    toned = np.clip(grid.own * carried_tone(colors, grid.own, seen), 0, 1)
    share = feather(seen)[..., None]
    mixed = np.where(seen[..., None], share * np.nan_to_num(colors) + (1 - share) * toned, toned)
    return filled(mixed)


def expression_texture(
    grid: TexelGrid, source: CylinderMap, warp: SkinWarp, base: Float[np.ndarray, "h w 3"]
) -> tuple[Float[np.ndarray, "h w 3"], Bool[np.ndarray, "h w"]]:
    """An expression's colours in step with the base texture, levelled to it; the base where it shows nothing."""
    pixels = np.nan_to_num(grid.pixels, nan=-9.0)
    places = sampled(warp.pixels, pixels)
    _, colors = source.at(places)
    seen = grid.shown & (sampled(warp.shown.astype(float), pixels)[..., 0] > 0.5) & np.isfinite(colors[..., 0])
    if not seen.any():
        return base, seen
    gain = np.median(base[seen] / np.maximum(colors[seen], DARK), axis=0)
    share = feather(seen)[..., None]
    return np.clip(base + share * (np.nan_to_num(colors) * gain - base), 0, 1), seen


def feather(seen: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    """0 outside, rising to 1 over `FEATHER` texels from the rim inwards."""
    away = np.asarray(distance_transform_edt(seen))
    return np.clip(away / FEATHER, 0, 1)


def carried_tone(
    colors: Float[np.ndarray, "h w 3"], own: Float[np.ndarray, "h w 3"], seen: Bool[np.ndarray, "h w"]
) -> Float[np.ndarray, "h w 3"]:
    """By what the own colours must be multiplied to go on where the captured ones end."""
    ratio = np.where(seen[..., None], np.nan_to_num(colors) / np.maximum(np.nan_to_num(own, nan=1.0), DARK), 0.0)
    overall = np.median(ratio[seen], axis=0) if seen.any() else np.ones(3)
    some, there = ratio[::COARSE, ::COARSE].astype(np.float32), seen[::COARSE, ::COARSE]
    tone, left = np.broadcast_to(overall, some.shape).copy(), np.ones(there.shape, bool)
    for sigma in TONES:
        share = gaussian_filter(there.astype(np.float32), sigma, truncate=3.0)
        near = left & (share > 0.05)
        blurred = [gaussian_filter(some[..., c], sigma, truncate=3.0) for c in range(3)]
        tone[near] = (np.stack(blurred, -1) / np.maximum(share, 1e-6)[..., None])[near]
        left &= ~near
    return sampled(tone, grid_of(seen.shape) / COARSE)


def as_bytes(colors: Float[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "h w 3"]:
    """sRGB in 0..1 as bytes."""
    return (np.clip(np.nan_to_num(colors), 0, 1) * 255 + 0.5).astype(np.uint8)


def _scattered(values: np.ndarray, on: Bool[np.ndarray, "h w"], nothing) -> np.ndarray:
    image = np.full((*on.shape, *values.shape[1:]), nothing, values.dtype)
    image[on] = values
    return image
