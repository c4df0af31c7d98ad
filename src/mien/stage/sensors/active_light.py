"""A camera that watches a face under a projector's patterns and under lamps all round, with the faults of each."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage
from scipy.spatial import cKDTree

from ...camera import Camera
from ...mesh import Mesh, vertex_normals
from ...pictures.color import to_linear
from ...pictures.raycast import depth_image
from ...transforms import Transform

SHADOW_MM = 1.5
"""A point this much behind what the projector sees first is in its shadow."""
GLOSS = 40.0
"""Exponent of the projector's highlight (Blinn)."""


class Placed(NamedTuple):
    """A camera, or a projector, and where it stands."""

    camera: Camera
    T_view_face: Transform


class Slot(NamedTuple):
    """What shines while one picture is taken: a pattern along the projector's columns or rows, or the lamps."""

    columns: Float[np.ndarray, " w"] | None = None
    """Linear 0..1, a value a projector column."""
    rows: Float[np.ndarray, " h"] | None = None
    gradient: tuple[float, float, float] | None = None
    """Lamps: light from direction d has (1 + gradient . d) / 2 of full strength, face space; (0, 0, 0) twice that."""


@dataclass(frozen=True)
class ActiveLightConfig:
    """What goes wrong with pictures of active light. All zeros and gamma 1: nothing."""

    read_noise: float = 0.003
    """Standard deviation, share of full scale."""
    shot_noise: float = 0.004
    """Standard deviation at full scale; it grows with the root of the light."""
    bits: int = 12
    """Of the camera."""
    gamma: float = 1.0
    """Stored value = linear ^ (1 / gamma)."""
    ambient: float = 0.01
    """Of the room, share of the projector's light."""
    specular: float = 0.0
    """Strength of highlights beside the matt reflection of white skin: 0.3 is moist skin without polarisers."""
    subsurface_mm: float = 0.5
    """Standard deviation of the blur that light suffers under the skin."""
    exposure: float = 2.2
    """Picture value of a white surface that faces the light: skin of a third of white comes to 0.7."""


@dataclass(frozen=True)
class Dots:
    """Round dots of make-up: they stretch with the skin, since they are told by its points at rest."""

    resting: Float[np.ndarray, "n 3"]
    """The mesh's vertices at rest, face space, mm."""
    centres: Float[np.ndarray, "k 3"]
    """On that resting skin."""
    radius_mm: float = 1.5
    reflectance: float = 0.06
    """Of white."""


@dataclass(frozen=True)
class VisibleSkin:
    """What one camera sees of a mesh: geometry before light."""

    mask: Bool[np.ndarray, "h w"]
    points: Float[np.ndarray, "p 3"]
    """Face space, mm."""
    normals: Float[np.ndarray, "p 3"]
    toward: Float[np.ndarray, "p 3"]
    """Unit vectors to the camera."""
    albedo: Float[np.ndarray, " p"]
    pixel_mm: float
    """Size of a pixel on the skin."""


def look(mesh: Mesh, view: Placed, dots: Dots | None = None) -> VisibleSkin:
    """Cast the camera's rays."""
    image = depth_image(mesh, view.camera, view.T_view_face)
    hit = image.faces >= 0
    corners, weights = mesh.faces[image.faces[hit]], image.barycentric[hit]
    normals = np.einsum("pk,pkc->pc", weights, vertex_normals(mesh.vertices, mesh.faces)[corners])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = np.einsum("pk,pkc->pc", weights, mesh.vertices[corners])
    grey = np.full(len(mesh.vertices), 0.6) if mesh.colors is None else to_linear(mesh.colors).mean(axis=1)
    eye = view.T_view_face.inverse().translation
    toward = eye - points
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    depth = float(np.median(image.depth[hit]))
    albedo = (weights * grey[corners]).sum(1)
    if dots is not None:
        rest = np.einsum("pk,pkc->pc", weights, dots.resting[corners])
        dotted = cKDTree(dots.centres).query(rest, distance_upper_bound=dots.radius_mm)[0] < dots.radius_mm
        albedo = np.where(dotted, dots.reflectance, albedo)
    return VisibleSkin(hit, points, normals, toward, albedo, depth / view.camera.fx)


def picture(
    seen: VisibleSkin, mesh: Mesh, projector: Placed, slot: Slot, config: ActiveLightConfig, rng: np.random.Generator
) -> Float[np.ndarray, "h w"]:
    """What the camera stores in one slot, 0..1."""
    if slot.gradient is None:
        light, shine = projected(seen, mesh, projector, slot)
    else:
        light, shine = from_lamps(seen, slot.gradient)
    light = blurred(light + config.ambient, seen, config.subsurface_mm)
    value = np.zeros(seen.mask.shape)
    value[seen.mask] = config.exposure * (seen.albedo * light + config.specular * shine)
    noise = np.sqrt(config.read_noise**2 + config.shot_noise**2 * np.maximum(value, 0))
    value = np.clip(value + noise * rng.normal(size=value.shape), 0, 1) ** (1 / config.gamma)
    steps = 2**config.bits - 1
    return np.round(value * steps) / steps


def projected(
    seen: VisibleSkin, mesh: Mesh, projector: Placed, slot: Slot
) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"]]:
    """Light that arrives and its highlight: the pattern at each point, Lambert's cosine, shadows."""
    local = projector.T_view_face.apply(seen.points)
    pixels = projector.camera.project(local)
    first = depth_image(mesh, projector.camera, projector.T_view_face).depth
    nearest = np.where(np.isfinite(first), first, np.inf)
    x, y = np.round(pixels).astype(int).T
    inside = (x >= 0) & (x < projector.camera.width) & (y >= 0) & (y < projector.camera.height)
    before = nearest[np.clip(y, 0, len(nearest) - 1), np.clip(x, 0, nearest.shape[1] - 1)]
    lit = inside & (local[:, 2] < before + SHADOW_MM)
    pattern = np.ones(len(pixels))
    if slot.columns is not None:
        pattern = np.interp(pixels[:, 0], np.arange(len(slot.columns)), slot.columns)
    if slot.rows is not None:
        pattern = pattern * np.interp(pixels[:, 1], np.arange(len(slot.rows)), slot.rows)
    lamp = projector.T_view_face.inverse().translation - seen.points
    lamp /= np.linalg.norm(lamp, axis=1, keepdims=True)
    cosine = np.clip((lamp * seen.normals).sum(1), 0, None)
    half = lamp + seen.toward
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    shine = np.clip((half * seen.normals).sum(1), 0, None) ** GLOSS
    return lit * pattern * cosine, lit * pattern * shine


def from_lamps(
    seen: VisibleSkin, gradient: tuple[float, float, float]
) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"]]:
    """Light of a whole sphere of lamps: on a matt convex point (1 + 2/3 g . n) / 2, its mirror image (1 + g . r) / 2.

    The even light (no gradient) is full strength from everywhere.
    """
    g = np.array(gradient)
    if not g.any():
        return np.ones(len(seen.normals)), fresnel(seen)
    mirrored = 2 * (seen.normals * seen.toward).sum(1, keepdims=True) * seen.normals - seen.toward
    return (1 + 2 / 3 * seen.normals @ g) / 2, fresnel(seen) * (1 + mirrored @ g) / 2


def fresnel(seen: VisibleSkin) -> Float[np.ndarray, " p"]:
    """How much more skin mirrors at grazing angles (Schlick's formula), 1 from the front at most 25."""
    cosine = np.clip((seen.normals * seen.toward).sum(1), 0, 1)
    return 0.2 * (1 + 24 * (1 - cosine) ** 5)


def blurred(light: Float[np.ndarray, " p"], seen: VisibleSkin, sigma_mm: float) -> Float[np.ndarray, " p"]:
    """Light that has wandered under the skin."""
    if sigma_mm == 0:
        return light
    image, weight = np.zeros(seen.mask.shape), seen.mask.astype(float)
    image[seen.mask] = light
    sigma = sigma_mm / seen.pixel_mm
    return (ndimage.gaussian_filter(image, sigma) / np.maximum(ndimage.gaussian_filter(weight, sigma), 1e-6))[seen.mask]
