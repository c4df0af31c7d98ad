"""The map's colour: frames projected onto it, levelled, blended without seams (after Casas et al. 2016, sec. 3).

The paper projects the reference frame. A few frames from several sides show more, and each point straighter on.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Float32
from scipy.ndimage import gaussian_filter

from ...camera import Camera
from ...image_space.layout import sampled
from ...pictures.color import to_linear, to_srgb
from .frames import PlacedFrame

HIDDEN_MM = 6.0
"""A point this much farther than the frame's depth there is hidden in the frame."""
BIN_RAD = 0.17
"""Frames from directions closer than this show the same: the sharpest of them is taken."""
TINY = 1e-6


@dataclass(frozen=True)
class ColourConfig:
    """How frames make one texture."""

    source: Literal["blend", "reference"] = "blend"
    """All sides blended, or the reference frame alone, as the paper has it."""
    most: int = 9
    """Frames that are blended, each the sharpest of its direction."""
    level: bool = True
    """Exposure and white balance of each frame are brought to the reference's."""
    band_mm: float = 5.0
    """Coarser tones blend softly over all frames, finer detail comes from the frame that sees it best; 0: one band."""
    softness: float = 2.0
    """Power of the cosine in the soft weights."""
    choice: float = 12.0
    """The same for fine detail: more is closer to one frame a pixel."""


@dataclass(frozen=True)
class Photo:
    """One frame's colours on the map."""

    colors: Float[np.ndarray, "h w 3"]
    """Linear light; 0 where the frame does not see the point."""
    facing: Float[np.ndarray, "h w"]
    """Cosine between the surface's normal and the way to the sensor; 0 where not seen."""


def photograph(
    placed: PlacedFrame, positions: Float32[np.ndarray, "h w 3"], normals: Float32[np.ndarray, "h w 3"], camera: Camera
) -> Photo:
    """What a frame says of the colour of each point of the map."""
    T_camera_face = placed.T_face_camera.inverse()
    flat = T_camera_face.apply(np.nan_to_num(positions.reshape(-1, 3)).astype(np.float64))
    away = np.linalg.norm(flat, axis=1)
    facing = -(T_camera_face.rotate(np.nan_to_num(normals.reshape(-1, 3))) * flat).sum(1) / np.maximum(away, TINY)
    there = np.isfinite(positions[..., 0]).ravel() & (flat[:, 2] > 1)
    pixels = np.where(there[:, None], camera.project(np.where(there[:, None], flat, [0, 0, 1.0])), -1)
    inside = there & (pixels > 0).all(1) & (pixels[:, 0] < camera.width - 1) & (pixels[:, 1] < camera.height - 1)
    column, row = np.clip(np.round(pixels), 0, [camera.width - 1, camera.height - 1]).astype(int).T
    depth = placed.seen.depth[row, column]
    seen = inside & ((depth <= 0) | (flat[:, 2] < depth + HIDDEN_MM))
    facing = np.where(seen, np.clip(facing, 0, 1), 0)
    colors = np.zeros((len(flat), 3))
    use = facing > 0
    color = placed.seen.frame.color
    assert color is not None
    colors[use] = to_linear(np.clip(sampled(color.astype(np.float32), pixels[use]) / 255, 0, 1))
    shape = positions.shape[:2]
    return Photo(colors.reshape(*shape, 3), facing.reshape(shape))


def chosen_frames(placed: list[PlacedFrame], reference: int, config: ColourConfig) -> list[int]:
    """Frames whose colour is used, the reference first: the sharpest of each direction."""
    if config.source == "reference":
        return [reference]
    ways = np.stack([-one.T_face_camera.rotation[:, 2] for one in placed])
    sharp = np.array([sharpness(one) for one in placed])
    kept = [reference]
    for i in np.argsort(-sharp):
        turned = np.arccos(np.clip(ways[kept] @ ways[i], -1, 1))
        if turned.min() > BIN_RAD and len(kept) < config.most:
            kept.append(int(i))
    return kept


def sharpness(placed: PlacedFrame) -> float:
    """How much fine detail the face has in a frame's picture: mean square of what a small blur takes away."""
    color = placed.seen.frame.color
    assert color is not None
    rows, columns = np.nonzero(placed.seen.depth > 0)
    grey = color[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1].astype(np.float32) @ [0.3, 0.6, 0.1]
    return float(((grey - gaussian_filter(grey, 1.0)) ** 2).mean())


def level(photos: list[Photo]) -> list[Photo]:
    """Every photo with one gain a channel that brings it to the first one where both see the skin well."""
    levelled = [photos[0]]
    for photo in photos[1:]:
        both = (photos[0].facing > 0.5) & (photo.facing > 0.5) & _lit(photos[0].colors) & _lit(photo.colors)
        if both.sum() < 200:
            levelled.append(photo)
            continue
        gain = np.exp(np.median(np.log(photos[0].colors[both] / photo.colors[both]), axis=0))
        levelled.append(Photo(photo.colors * gain, photo.facing))
    return levelled


def blend(photos: list[Photo], pixel_mm: float, config: ColourConfig) -> Float32[np.ndarray, "h w 3"]:
    """One picture from all: tones softly, detail from the straightest view; sRGB in 0..1, NaN where none sees."""
    if config.level:
        photos = level(photos)
    colors = np.stack([to_srgb(photo.colors).astype(np.float32) for photo in photos])
    facing = np.stack([photo.facing.astype(np.float32) for photo in photos])
    soft = _normalised(facing**config.softness)
    out = (soft[..., None] * colors).sum(0)
    if config.band_mm > 0 and len(photos) > 1:
        sigma = config.band_mm / pixel_mm
        sharp = _normalised(np.stack([gaussian_filter(f, sigma / 3) * (f > 0) for f in facing**config.choice]))
        fine = np.stack([_detail(c, f > 0, sigma) for c, f in zip(colors, facing, strict=True)])
        out = out - (soft[..., None] * fine).sum(0) + (sharp[..., None] * fine).sum(0)
    out[facing.max(0) <= 0] = np.nan
    return np.clip(out, 0, 1).astype(np.float32)


def normals_of(positions: Float32[np.ndarray, "h w 3"]) -> Float32[np.ndarray, "h w 3"]:
    """Unit normals of a map, outwards, by differences of neighbours; NaN beside holes."""
    across = np.gradient(positions, axis=1)
    down = np.gradient(positions, axis=0)
    normal = np.cross(down, across)
    return normal / np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), TINY)


def _detail(color: np.ndarray, seen: Bool[np.ndarray, "h w"], sigma: float) -> np.ndarray:
    """What is finer than the band, 0 where not seen."""
    share = gaussian_filter(seen.astype(np.float32), sigma, truncate=2.5)
    broad = np.stack([gaussian_filter(color[..., c] * seen, sigma, truncate=2.5) for c in range(3)], -1)
    return np.where(seen[..., None], color - broad / np.maximum(share, TINY)[..., None], 0)


def _normalised(weights: np.ndarray) -> np.ndarray:
    return weights / np.maximum(weights.sum(0), TINY)


def _lit(colors: np.ndarray) -> Bool[np.ndarray, "h w"]:
    """Neither black nor burnt out."""
    return np.asarray((colors.min(-1) > 0.01) & (colors.max(-1) < 0.95))
