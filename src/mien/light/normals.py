"""Normals and albedo from light that comes from known directions: gradients, or lamps one at a time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from .._kernels import photometric as kernel
from .._kernels._spread import spread
from ..errors import BadInput
from ..image_space.window import GaussianWindow
from .patterns import PatternSet

LAMBERT = 2.0 / 3.0
"""Length of 2 L / L_c - 1 for a matt convex surface under linear gradients over the whole sphere."""
NEWTON_ROUNDS = 5
"""Of finding a normal behind its highlight; three are enough up to a third of mirrored light."""
LEAST_LIGHT = 0.02
"""Share of full scale below which the constant condition says nothing."""


@dataclass(frozen=True)
class NormalMap:
    """What light tells of a surface, pixel by pixel."""

    normals: Float[np.ndarray, "h w 3"]
    """Unit vectors, camera space (towards the camera: z < 0); NaN where nothing is known."""
    confidence: Float[np.ndarray, "h w"]
    """1 where all is as a matt unshadowed surface would have it; towards 0 in creases, shadows and highlights."""
    albedo: Float[np.ndarray, "h w"]
    """Reflectance, up to one factor for the picture."""

    @property
    def known(self) -> Bool[np.ndarray, "h w"]:
        """Where there is a normal."""
        return np.isfinite(self.normals[..., 0])


def gradient_normals(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, R_view_lamps: Float[np.ndarray, "3 3"]
) -> NormalMap:
    """Normals, in the view's space, from three gradients of light and the constant condition (Ma et al. 2007).

    `L_i / L_c = (1 + 2/3 n_i) / 2` for a matt convex surface, hence `n_i = 3/2 (2 L_i / L_c - 1)`. The vector's length
    says how far that holds: what hides part of the sphere of lamps, or shines, changes it.

    Raises:
        BadInput: a condition is missing.
    """
    constant = images[patterns.one("constant")]
    slots = [patterns.of("gradient", axis=axis) for axis in "xyz"]
    if any(len(found) != 1 for found in slots):
        raise BadInput(f"patterns: expected one gradient of x, y and z each, got {[len(found) for found in slots]}")
    lit = constant > LEAST_LIGHT
    safe = np.where(lit, constant, 1.0)
    vectors = np.stack([2 * images[found[0]] / safe - 1 for found in slots], -1)
    length = np.linalg.norm(vectors, axis=-1)
    turned = vectors @ R_view_lamps.T
    lit &= length > 0.05
    normals = np.where(lit[..., None], turned / np.where(lit, length, 1.0)[..., None], np.nan)
    confidence = np.where(lit, np.clip(1 - np.abs(length / LAMBERT - 1), 0, 1), 0.0)
    return NormalMap(normals, confidence, np.where(lit, constant, np.nan))


@dataclass(frozen=True)
class GlossConfig:
    """How highlights are taken out of normals from gradients."""

    window_px: float = 12.0
    """Standard deviation of the window over which the share of mirrored light is one, pixels. 0: they stay."""
    most: float = 0.6
    """Greatest share."""
    least_slant: float = 0.02
    """Mean square of sines below which a window tells no share: seen straight on, mirrored and matt light agree."""


def without_highlights(
    light: NormalMap,
    geometry: Float[np.ndarray, "h w 3"],
    rays: Float[np.ndarray, "h w 3"],
    config: GlossConfig = GlossConfig(),
) -> NormalMap:
    """Normals of a skin that also mirrors the lamps, with no polarisers.

    A gradient's mirror image leans to the mirrored line of sight r: what is measured is (1 - w) 2/3 n + w r, in the
    plane of n and the sight. With the normals of the `geometry` in place of n, its direction tells w, one share a
    window (least squares); with w, the direction tells n pixel by pixel (Newton).
    """
    if config.window_px <= 0:
        return light
    sight = -rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    across = light.normals - (light.normals * sight).sum(-1, keepdims=True) * sight
    across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-9)
    seen = np.arctan2((light.normals * across).sum(-1), (light.normals * sight).sum(-1))
    told = np.arctan2((geometry * across).sum(-1), (geometry * sight).sum(-1))
    matt, mirrored = LAMBERT * np.sin(seen - told), np.sin(2 * told - seen)
    known = np.isfinite(matt + mirrored)
    if not known.any():
        return light
    window = GaussianWindow(known, config.window_px)
    m, r = matt[known], mirrored[known]
    top, bottom, weight = np.moveaxis(window.sums(np.stack([m * (m + r), (m + r) ** 2, np.ones_like(m)], 1)), -1, 0)
    told_by = np.clip(top / np.maximum(bottom, config.least_slant * np.maximum(weight, 1e-6)), 0.0, config.most)
    share = GaussianWindow(light.known, config.window_px).at_pixels(told_by[..., None])[:, 0]
    normals = light.normals.copy()
    normals[light.known] = behind_highlight(seen[light.known], share, sight[light.known], across[light.known])
    return NormalMap(normals, light.confidence, light.albedo)


def behind_highlight(
    seen: Float[np.ndarray, " p"],
    share: Float[np.ndarray, " p"],
    sight: Float[np.ndarray, "p 3"],
    across: Float[np.ndarray, "p 3"],
) -> Float[np.ndarray, "p 3"]:
    """Normals at the angle from the sight that, mirrored light and all, is seen at `seen`."""
    angle = seen
    for _ in range(NEWTON_ROUNDS):
        off = (1 - share) * LAMBERT * np.sin(angle - seen) + share * np.sin(2 * angle - seen)
        slope = (1 - share) * LAMBERT * np.cos(angle - seen) + 2 * share * np.cos(2 * angle - seen)
        angle = np.clip(angle - off / np.maximum(slope, 0.1), 0.0, seen)
    return np.cos(angle)[..., None] * sight + np.sin(angle)[..., None] * across


@dataclass(frozen=True)
class PointLamp:
    """A small lamp at a known place, or far away."""

    position: tuple[float, float, float]
    """mm, camera space; a direction towards the lamp if it is far."""
    intensity: float = 1.0
    """Picture value = albedo * intensity * cos(angle) / distance^2 (no distance if far)."""
    axis: tuple[float, float, float] | None = None
    """Where it looks; None: the same to all sides."""
    mu: float = 0.0
    """Fall-off with the angle to the axis: cos^mu."""
    far: bool = False

    def light(self, points: Float[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n 3"]:
        """The light vector at points: direction to the lamp times what arrives."""
        place = np.array(self.position)
        if self.far:
            return np.broadcast_to(self.intensity * place / np.linalg.norm(place), points.shape)
        to_lamp = place - points
        distance = np.linalg.norm(to_lamp, axis=-1, keepdims=True)
        arriving = self.intensity / distance**3
        if self.axis is not None and self.mu:
            aim = np.array(self.axis) / np.linalg.norm(self.axis)
            arriving = arriving * np.clip(-(to_lamp @ aim)[..., None] / distance, 0, 1) ** self.mu
        return to_lamp * arriving


@dataclass(frozen=True)
class PhotometricStereoConfig:
    """Photometric stereo by reweighted least squares."""

    rounds: int = 8
    robust: float = 0.08
    """Residuals beyond this share of the brightest frame count less: highlights, cast shadows."""
    shadow: float = 0.02
    """Values below this share of full scale are shadow, and left out of their pixel."""
    brightest: float = 0.99
    """Saturated values are left out."""
    least: int = 3
    """Lamps that a pixel needs."""


def photometric_normals(
    images: Float[np.ndarray, "lamps h w"],
    lamps: list[PointLamp],
    points: Float[np.ndarray, "h w 3"],
    mask: Bool[np.ndarray, "h w"],
    config: PhotometricStereoConfig = PhotometricStereoConfig(),
) -> NormalMap:
    """Normals and albedo from lamps one at a time: `image_k = albedo max(0, n . light_k)`, linear pictures.

    Frames in which a pixel shines or lies in shadow are outliers to a matt surface, and count less and less
    (iteratively reweighted least squares with Cauchy weights).

    Args:
        points: where the surface is about, camera space, mm: near lamps need it.

    Raises:
        BadInput: fewer than three lamps, or pictures of another number.
    """
    if len(lamps) < 3 or len(images) != len(lamps):
        raise BadInput(
            f"photometric stereo: expected 3 lamps or more and a picture each, got {len(lamps)}, {len(images)}"
        )
    values = images[:, mask].T
    light = np.stack([lamp.light(points[mask]) for lamp in lamps], 1)
    usable = (values > config.shadow) & (values < config.brightest)
    scales = config.robust * np.maximum(values.max(axis=1), config.shadow)
    scaled, weight = np.zeros((len(values), 3)), np.zeros_like(values)

    def rows(first: int, last: int) -> None:
        p = slice(first, last)
        told = (values[p], light[p], usable[p], scales[p])
        kernel.robust_normals(*told, config.rounds, scaled[p], weight[p])

    spread(rows, len(values))
    albedo = np.linalg.norm(scaled, axis=1)
    known = (usable.sum(1) >= config.least) & (albedo > 0)
    out = NormalMap(*(np.full((*mask.shape, *shape), np.nan) for shape in ((3,), (), ())))
    out.normals[mask] = np.where(known[:, None], scaled / np.where(known, albedo, 1.0)[:, None], np.nan)
    trust = (weight * np.abs(values)).sum(1) / np.maximum(np.abs(values).sum(1), 1e-12)
    out.confidence[mask] = np.where(known, trust, 0.0)
    out.albedo[mask] = np.where(known, albedo, np.nan)
    return NormalMap(out.normals, np.nan_to_num(out.confidence), out.albedo)
