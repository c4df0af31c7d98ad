"""Depth cameras and what they get wrong, from exact depth images."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Bool, Float, Float32
from scipy.ndimage import gaussian_filter, maximum_filter, minimum_filter

from ...camera import Camera
from ...errors import BadInput

BANK = 2048
"""Pixels a side of the noise that frames cut theirs out of."""


@dataclass(frozen=True)
class DepthSensor:
    """How one kind of depth camera errs. `structured_light()` and `time_of_flight()` give the two usual kinds."""

    camera: Camera
    """Of colour and depth alike: depth comes registered to colour."""
    noise: float
    """Standard deviation of a pixel at 700 mm facing the camera, mm; grows with the distance squared."""
    correlation: float
    """How far neighbouring pixels err alike, pixels (Gaussian sigma). 0: each by itself."""
    ripple: float
    """Rms of errors that stay in the picture from frame to frame (lens, calibration), mm at 700 mm. 0: none."""
    disparity_step: float
    """Step of the disparities that depth is computed from, pixels. 0: no such steps."""
    depth_step: float
    """Step of the depth values, mm. 0: none."""
    baseline: float
    """From projector to camera, mm, projector at the left (-x); what it cannot reach has no depth. 0: no shadow."""
    grazing: float
    """No depth where the cosine of ray to normal is below this, and ever less often up to twice that. 0: everywhere."""
    flying: float
    """Share of pixels at the edge of a step in depth that float between near and far. 0: none."""
    lost: float
    """Share of all pixels that are missing for no reason. 0: none."""
    dark: float
    """How much more noise black surfaces have than white ones, as a factor less 1. 0: colour does not matter."""
    nearest: float = 250.0
    """No depth nearer than this, mm."""
    farthest: float = 4000.0
    """No depth beyond this, mm."""


def structured_light() -> DepthSensor:
    """Kinect-like: 640 x 480, coarse disparities, a shadow beside what sticks out. A pixel errs by 0.8 mm at 700 mm."""
    return DepthSensor(
        camera=Camera(580.0, 580.0, 319.5, 239.5, 640, 480), noise=0.8, correlation=0.6, ripple=0.25,
        disparity_step=0.125, depth_step=0.0, baseline=75.0, grazing=0.18, flying=0.1, lost=0.002, dark=0.5,
        nearest=400.0,
    )  # fmt: skip


def time_of_flight() -> DepthSensor:
    """TrueDepth- or ToF-like: 640 x 480, smoother and finer, more flying pixels, no shadow."""
    return DepthSensor(
        camera=Camera(595.0, 595.0, 319.5, 239.5, 640, 480), noise=0.7, correlation=1.1, ripple=0.3,
        disparity_step=0.0, depth_step=0.25, baseline=0.0, grazing=0.12, flying=0.45, lost=0.001, dark=1.0,
    )  # fmt: skip


@dataclass(frozen=True)
class Seen:
    """An exact view of the stage."""

    depth: Float[np.ndarray, "h w"]
    """mm; NaN for none."""
    facing: Float[np.ndarray, "h w"]
    """Cosine of the ray to the surface's normal."""
    lit: Bool[np.ndarray, "h w"]
    """Reached by the projector."""
    brightness: Float[np.ndarray, "h w"]
    """Of the surface, 0..1."""


def record(seen: Seen, sensor: DepthSensor, rng: np.random.Generator) -> Float32[np.ndarray, "h w"]:
    """What the sensor delivers: mm, 0 where it has nothing.

    Noise grows with z^2 as a triangulating sensor's does (Khoshelham and Elberink 2012), and towards grazing angles.
    """
    depth = np.nan_to_num(seen.depth)
    there = depth > 0
    depth = np.where(there, _fly(depth, there, sensor, rng), 0.0)
    scale = (depth / 700.0) ** 2
    slant = 1.0 / np.sqrt(np.clip(np.abs(seen.facing), 0.15, 1.0))
    dark = 1.0 + sensor.dark * np.clip(1 - seen.brightness / 0.5, 0, 1)
    depth = depth + scale * (sensor.noise * slant * dark * cut_noise(depth.shape, sensor.correlation, rng))
    depth = depth + scale * sensor.ripple * _standing(depth.shape, sensor.baseline)
    depth = _stepped(depth, sensor)
    facing = np.nan_to_num(np.abs(seen.facing))
    graze = rng.random(depth.shape) > np.clip(facing / max(sensor.grazing, 1e-9) - 1.0, 0.0, 1.0)
    gone = (graze & (sensor.grazing > 0)) | ~seen.lit | (rng.random(depth.shape) < sensor.lost) | ~there
    gone |= (depth < sensor.nearest) | (depth > sensor.farthest)
    return np.where(gone, 0.0, depth).astype(np.float32)


@cache
def noise_bank(correlation: float) -> Float32[np.ndarray, "rows columns"]:
    """Noise of unit variance that neighbours share, more than a picture of it: frames cut their noise out of it."""
    grain = np.random.default_rng(11).standard_normal((BANK, BANK), dtype=np.float32)
    if correlation <= 0:
        return grain
    soft = gaussian_filter(grain, correlation, mode="wrap")
    return soft / soft.std()


def cut_noise(shape: tuple[int, ...], correlation: float, rng: np.random.Generator) -> Float32[np.ndarray, "h w"]:
    """A random window of the bank, randomly turned over.

    Raises:
        BadInput: the picture is larger than the bank.
    """
    h, w = shape
    if max(h, w) > BANK:
        raise BadInput(f"camera: expected at most {BANK} pixels a side, got {w} x {h}")
    bank = noise_bank(correlation)[:: rng.choice([-1, 1]), :: rng.choice([-1, 1])]
    y, x = rng.integers(BANK - h + 1), rng.integers(BANK - w + 1)
    return bank[y : y + h, x : x + w] * np.float32(rng.choice([-1, 1]))


@cache
def _standing(shape: tuple[int, ...], phase: float) -> np.ndarray:
    """The errors that do not change from frame to frame, unit rms: a few slow waves over the picture."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float32)
    waves = ((0.031, 0.012, 0.3), (-0.017, 0.043, 1.9), (0.052, -0.038, 4.1), (0.011, 0.024, 2.7))
    return np.sqrt(0.5) * np.sum([np.cos(a * x + b * y + c + phase) for a, b, c in waves], axis=0)


def _stepped(depth: np.ndarray, sensor: DepthSensor) -> np.ndarray:
    """Rounded to whole steps of disparity, then of depth."""
    if sensor.disparity_step > 0:
        reach = sensor.camera.fx * max(sensor.baseline, 1.0)
        steps = np.round(reach / np.maximum(depth, 1.0) / sensor.disparity_step)
        depth = np.where(depth > 0, reach / np.maximum(steps * sensor.disparity_step, 1e-9), 0.0)
    if sensor.depth_step > 0:
        depth = np.round(depth / sensor.depth_step) * sensor.depth_step
    return depth


def _fly(depth: np.ndarray, there: np.ndarray, sensor: DepthSensor, rng: np.random.Generator) -> np.ndarray:
    """Pixels at the edge of a step of over 15 mm take some depth between its two sides."""
    if sensor.flying <= 0:
        return depth
    far = maximum_filter(np.where(there, depth, 0.0), 3)
    near = minimum_filter(np.where(there, depth, 1e9), 3)
    edge = there & (far - near > 15.0) & (rng.random(depth.shape) < sensor.flying)
    mixed = near + (far - near) * rng.random(depth.shape) ** 2
    return np.where(edge, mixed, depth)
