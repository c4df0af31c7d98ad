"""A surface from one camera and a few lamps near it: normals and depth by turns."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from ..camera import Camera
from ..errors import BadInput
from ..files import existing
from .fuse import small_holes
from .integrate import extended, integrate
from .normals import NormalMap, PhotometricStereoConfig, PointLamp, photometric_normals
from .triangulate import pieces, pixel_rays

JUDGED = 4000
"""Pixels on which a distance is judged."""


@dataclass(frozen=True)
class NearLightConfig:
    """The search for a surface that explains all pictures."""

    rounds: int = 6
    """Normals from where the surface is, then the surface from its normals; each halves what is left. On the smallest
    pictures; on each larger size one is enough."""
    smallest: int = 20_000
    """Pixels of the face on which the surface is first found; sizes double from there."""
    start_mm: float | None = None
    """Mean distance from the camera. None: the one that the pictures fit best, since near lamps fall off with it."""
    distances_mm: tuple[float, float] = (300.0, 1500.0)
    """Between which it is sought."""
    photometric: PhotometricStereoConfig = PhotometricStereoConfig()
    hole_mm: float = 4.0
    """Dark specks no wider or taller than this are bridged. 0: none are."""
    smallest_piece: float = 0.01
    """Share of the mask; smaller pieces of surface are crumbs."""
    step_mm: float = 4.0
    """Neighbouring pixels farther apart in depth belong to different pieces."""


@dataclass(frozen=True)
class NearLightSurface:
    """What was found."""

    z: Float[np.ndarray, "h w"]
    """Along the camera's axis, mm; NaN off the mask. True to scale as far as the lamps' fall-off tells the distance."""
    light: NormalMap
    mean_mm: float
    residual: float
    """Median share of a picture's value that matt shading leaves unexplained."""


def near_light_surface(
    images: Float[np.ndarray, "lamps h w"],
    lamps: list[PointLamp],
    camera: Camera,
    mask: Bool[np.ndarray, "h w"],
    config: NearLightConfig = NearLightConfig(),
) -> NearLightSurface:
    """Photometric stereo under near lamps, linear pictures.

    Raises:
        BadInput: fewer than three lamps, or an empty mask.
    """
    if not mask.any():
        raise BadInput("near lamps: the mask is empty")
    mean = config.start_mm or best_distance(images, lamps, camera, mask, config)
    z = np.where(mask, mean, np.nan)
    steps = [2**k for k in range(halvings(int(mask.sum()), config.smallest), -1, -1)]
    for level, step in enumerate(steps):
        some = np.s_[::step, ::step]
        kept, seen = mask[some], every(camera, step)
        rays = pixel_rays(seen)
        z = enlarged(z, kept.shape) if level else z[some]
        for _ in range(1 if level else config.rounds):
            points = rays * np.nan_to_num(z, nan=mean)[..., None]
            light = photometric_normals(images[:, *some], lamps, points, kept, config.photometric)
            z = integrate(light.normals, seen, rays, kept, mean)
    known = np.where(light.known, z, np.nan)
    holes = small_holes(known, camera, config.hole_mm)
    z = np.where(light.known | holes, z, np.nan)
    z = np.where(pieces(z, config.step_mm) >= config.smallest_piece * mask.sum(), z, np.nan)
    return NearLightSurface(z, light, mean, unexplained(images, lamps, rays, z, light, mask))


def halvings(pixels: int, smallest: int) -> int:
    """How often a picture is halved until no more than so many pixels of the face are left."""
    return max(int(np.ceil(np.log2(pixels / smallest) / 2)), 0)


def every(camera: Camera, step: int) -> Camera:
    """The camera whose pixels are every `step`-th of the other's, from the first on."""
    size = [-(-pixels // step) for pixels in (camera.width, camera.height)]
    return Camera(camera.fx / step, camera.fy / step, camera.cx / step, camera.cy / step, *size)


def enlarged(z: Float[np.ndarray, "h w"], shape: tuple[int, ...]) -> Float[np.ndarray, "hh ww"]:
    """Depth on twice as many rows and columns; where nothing is known, that of the nearest pixel."""
    filled = extended(z[..., None], np.isfinite(z))[..., 0]
    y, x = np.mgrid[: shape[0], : shape[1]] / 2
    return ndimage.map_coordinates(filled, [y, x], order=1, mode="nearest")


def best_distance(
    images: np.ndarray, lamps: list[PointLamp], camera: Camera, mask: np.ndarray, config: NearLightConfig
) -> float:
    """The mean distance at which matt shading on a plane explains most, judged on some of the pixels."""
    coarse = np.zeros_like(mask)
    step = max(round(np.sqrt(mask.sum() / JUDGED)), 1)
    coarse[::step, ::step] = mask[::step, ::step]
    coarse = coarse if coarse.any() else mask
    rays = pixel_rays(camera)
    tried = np.geomspace(*config.distances_mm, 24)
    left = []
    for distance in tried:
        z = np.where(coarse, distance, np.nan)
        light = photometric_normals(images, lamps, rays * distance, coarse, config.photometric)
        left.append(unexplained(images, lamps, rays, z, light, coarse))
    return float(tried[int(np.argmin(left))])


def unexplained(
    images: np.ndarray, lamps: list[PointLamp], rays: np.ndarray, z: np.ndarray, light: NormalMap, mask: np.ndarray
) -> float:
    """Median over the mask of the absolute residual, as a share of the pixel's brightest picture.

    1 where the normal points away from the camera, which then could not see it.
    """
    known = mask & light.known & np.isfinite(z)
    points = (rays * z[..., None])[known]
    normal = light.normals[known] * light.albedo[known][:, None]
    shaded = np.stack([np.clip((lamp.light(points) * normal).sum(1), 0, None) for lamp in lamps])
    seen = images[:, known]
    away = (normal * points).sum(1) > 0
    left = np.median(np.abs(seen - shaded), axis=0) / np.maximum(seen.max(axis=0), 1e-9)
    return float(np.median(np.where(away, 1.0, left))) if known.any() else 1.0


def read_lamps(
    path: str | Path, channel: int | None = None
) -> tuple[list[PointLamp], list[str], Float[np.ndarray, "3 3"]]:
    """Lamps, their pictures' names and the camera's K from a `lights.json`.

    Each of `lights` has `image`, `position` (mm, camera space), optionally `direction`, `mu` and `intensity_rgb`
    (or `intensity`); `channel` picks one colour of the intensities, None takes their mean.

    Raises:
        BadInput: no such file, or not of lamps.
    """
    path = existing(path)
    try:
        told = json.loads(path.read_text())
        lamps, names = [], []
        for light in told["lights"]:
            strengths = np.atleast_1d(light.get("intensity_rgb", light.get("intensity", 1.0)))
            strength = float(strengths.mean() if channel is None else strengths[channel])
            axis = tuple(light["direction"]) if "direction" in light else None
            place = tuple(float(x) for x in light["position"])
            lamps.append(PointLamp((place[0], place[1], place[2]), strength, axis, float(light.get("mu", 0.0))))
            names.append(str(light["image"]))
        K = np.array(told["K"], float)
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        raise BadInput(
            f"{path}: no list of lamps ({error}); expected `lights` with image and position, and K"
        ) from None
    if K.shape != (3, 3):
        raise BadInput(f"{path}: expected K of 3 x 3, got {K.shape}")
    return lamps, names, K
