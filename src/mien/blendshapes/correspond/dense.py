"""The dense warp: optical flow on colour and curvature from the neutral to the pre-warped source (sec. 4.3).

The paper's flow is the anisotropic Huber-L1 flow of Werlberger et al. 2009; this one is variational, with robust
penalties on data and smoothness (Papenberg et al. 2006), and takes pinned points and masks as they are.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter, gaussian_laplace

from ...flow import FlowConfig, FlowConstraints, optical_flow
from ...image_space.config import FeatureConfig
from ...image_space.features import LUMINANCE, detail
from ...image_space.layout import grid_of, sampled
from ..cylinder_map import CylinderMap
from .landmarks import MapLandmarks, common_landmarks, mouth_opening, opened
from .matches import MatchConfig, matched_motion
from .occlusion import from_axis, outer_lips, skin
from .prewarp import prewarp

COLOUR = FeatureConfig(threshold=0.0, saturation=0.15, faint=0.006, broad_mm=8.0, nearby_mm=8.0)
"""Luminance of sRGB, 0..1: moles, brows, lips; tones broader than 8 mm are light and blood."""
CURVATURE = FeatureConfig(threshold=0.0, saturation=0.08, faint=0.006, broad_mm=14.0, nearby_mm=10.0)
"""1/mm."""
PARTED_MM = 4.0
"""Lips that open by so much keep to their landmarks as firmly as to a sure match; by twice as much, four times so."""
PINNED = 1e4
"""Weight of a point that is held by hand, against 1 for a sure match."""
PIN_PIXELS = 2
"""Of the flow's pixels so many to every side of such a point are held with it."""


@dataclass(frozen=True)
class WarpConfig:
    """How a source is brought to the neutral."""

    flow: FlowConfig | None = field(
        default_factory=lambda: FlowConfig(margin=24, coarsest=40, smoothness=1.0, constraint=1000.0)
    )
    """The dense flow; None: the landmarks' triangles alone, without matches."""
    passes: int = 2
    """Flows, each from where the one before ended: what is smooth is each one's step, not all that they find."""
    pixel_mm: float = 0.8
    """Side of the pixels that the flow is found in, mm; no finer than the map's."""
    curvature: float = 0.2
    """Weight of the curvature beside colour's 1; 0: colour alone. Skin that is pushed together bends anew."""
    curvature_mm: float = 1.6
    """Scale at which curvature is measured, mm."""
    landmarks: bool = True
    """The pre-warp; off: the flow starts from nothing."""
    believed_mm: float = 6.0
    """Where the flow goes farther than this from the pre-warp it is cut to that, mm."""
    matches: MatchConfig = field(default_factory=MatchConfig)
    """Patches that are looked for before the flow; `rounds` 0: none, as in the paper."""


@dataclass(frozen=True)
class SkinWarp:
    """For every pixel of the neutral's map where the same skin is in the source's."""

    pixels: Float[np.ndarray, "h w 2"]
    """Pixels (x, y) of the source's map."""
    shown: Bool[np.ndarray, "h w"]
    """Whether both maps show the skin there."""


def warp(
    source: CylinderMap,
    source_landmarks: MapLandmarks,
    neutral: CylinderMap,
    neutral_landmarks: MapLandmarks,
    expected: Float[np.ndarray, "h w 2"] | None = None,
    pinned: FlowConstraints | None = None,
    config: WarpConfig = WarpConfig(),
) -> SkinWarp:
    """Every pixel's place in the source: affine triangles between landmarks, then dense flow to what is there.

    Args:
        source: in the neutral's frame.
        expected: flow (dx, dy) from the neutral that the landmarks correct; None: none.
        pinned: points of the neutral's map and where they are in the source's, by hand, pixels.

    Raises:
        BadInput: too few landmarks in common.
    """
    layout = neutral.layout
    common = common_landmarks(source_landmarks, neutral_landmarks)
    there, here = opened(source_landmarks.pixels(layout)), opened(neutral_landmarks.pixels(layout))
    goals, starts = there[common], here[common]
    if pinned is not None:
        starts, goals = np.concatenate([starts, pinned.source]), np.concatenate([goals, pinned.target])
    grid = grid_of(layout.shape)
    if expected is not None:
        grid = grid + expected
        goals = goals - sampled(expected, starts)
    rough = grid + (prewarp(starts, goals, layout.shape) if config.landmarks else 0.0)
    masks = skin(neutral, here), skin(source, there)
    places = rough
    if config.flow is not None:
        images = features(neutral, masks[0], config), features(source, masks[1], config)
        open_mm = mouth_opening(there, here) * layout.pixel_mm
        steady = _steady(neutral, here, open_mm, pinned, _step(config.matches, layout.pixel_mm))
        places = _matched(images, rough, layout.pixel_mm, steady, config.matches)
        for _ in range(config.passes):
            places = _refined(images, places, layout.pixel_mm, pinned, config)
    inside = sampled(masks[1].astype(float), places)[..., 0] > 0.5
    return SkinWarp(places, masks[0] & inside)


def _step(config: WarpConfig | MatchConfig, pixel: float) -> int:
    """Every so many of the map's pixels are compared."""
    return max(1, round(config.pixel_mm / pixel))


def _steady(
    neutral: CylinderMap, pixels: Float[np.ndarray, "478 2"], open_mm: float, pinned: FlowConstraints | None, step: int
) -> Float[np.ndarray, "h w"]:
    """Weight of staying where the rough warp is: lips that part, whose patches hold what was not there; pins."""
    weight = np.where(outer_lips(pixels, neutral.layout.shape), (open_mm / PARTED_MM) ** 2, 0.0)[::step, ::step]
    if pinned is not None:
        most = [weight.shape[1] - 1, weight.shape[0] - 1]
        columns, rows = np.clip(np.round(pinned.source / step), 0, most).astype(int).T
        weight[rows, columns] = PINNED
    return weight


def _matched(images, rough, pixel: float, steady, config: MatchConfig) -> Float[np.ndarray, "h w 2"]:
    """Pre-warped places after patches were found, in rounds, until none moves far."""
    step = _step(config, pixel)
    places = rough
    for _ in range(config.rounds):
        target = sampled(images[1], places[::step, ::step])
        motion = matched_motion(images[0][::step, ::step], target, config, steady)
        places = _carried(places, motion, step)
        if np.linalg.norm(motion, axis=-1).max() * step * pixel < config.enough_mm:
            break
    return places


def _refined(images, rough, pixel: float, pinned, config: WarpConfig) -> Float[np.ndarray, "h w 2"]:
    """Pre-warped places after the flow, found on coarser pixels."""
    step = _step(config, pixel)
    target = sampled(images[1], rough[::step, ::step])
    held = None if pinned is None else _held(pinned.source / step, target.shape)
    found = optical_flow(images[0][::step, ::step], target, None, held, config.flow)
    flow = _cut(found.flow, config.believed_mm / (step * pixel))
    smooth = np.stack([gaussian_filter(flow[..., i], 0.7) for i in range(2)], -1)
    return _carried(rough, smooth, step)


def _held(points: Float[np.ndarray, "k 2"], shape: tuple[int, ...]) -> FlowConstraints:
    """Points that stay where they are, with the pixels round them: a single one would be smoothed away."""
    steps = np.mgrid[-PIN_PIXELS : PIN_PIXELS + 1, -PIN_PIXELS : PIN_PIXELS + 1].reshape(2, -1).T
    places = np.clip((points[:, None] + steps).reshape(-1, 2), 0, [shape[1] - 1, shape[0] - 1])
    return FlowConstraints(places, places)


def _carried(places: np.ndarray, motion: np.ndarray, step: int) -> Float[np.ndarray, "h w 2"]:
    """Places after a motion that was found on every `step`th pixel."""
    grid = grid_of(places.shape)
    return sampled(places, grid + step * sampled(motion, grid / step))


def features(map_: CylinderMap, mask: Bool[np.ndarray, "h w"], config: WarpConfig) -> Float[np.ndarray, "h w 2"]:
    """What is compared: fine colour and fine curvature, each divided by its strength nearby; NaN off the mask."""
    pixel = map_.layout.pixel_mm
    grey = np.where(mask, map_.colors.astype(np.float64) @ np.array(LUMINANCE), np.nan)
    channels = [detail(grey, COLOUR, pixel).scaled]
    if config.curvature > 0:
        bent = np.where(mask, curvature(map_, config.curvature_mm), np.nan)
        channels.append(config.curvature * detail(bent, CURVATURE, pixel).scaled)
    return np.where(mask[..., None], np.stack(channels, -1), np.nan)


def curvature(map_: CylinderMap, scale_mm: float) -> Float[np.ndarray, "h w"]:
    """Bending of the map's surface, 1/mm: minus the Laplacian of its height over the cylinder, at a scale."""
    radius = from_axis(map_).astype(np.float64)
    sigma = scale_mm / map_.layout.pixel_mm
    known = map_.known.astype(float)
    mean = gaussian_filter(np.nan_to_num(radius), 3 * sigma) / np.maximum(gaussian_filter(known, 3 * sigma), 1e-6)
    height = np.where(map_.known, radius - mean, 0.0)
    return -gaussian_laplace(height, sigma) / map_.layout.pixel_mm**2


def _cut(flow: np.ndarray, most: float) -> np.ndarray:
    length = np.linalg.norm(flow, axis=-1, keepdims=True)
    return flow * np.minimum(1.0, most / np.maximum(length, 1e-9))
