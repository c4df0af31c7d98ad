"""What skin looks like on the chart, whatever the light: pictures freed of their mean and contrast round about."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from ...image_space.features import averaged
from .front_chart import ChartedFrame

BLANK = 0.5
"""Contrast (grey levels of 255) below which a picture shows nothing."""


@dataclass(frozen=True)
class LookConfig:
    """The chart and the pictures on it."""

    pixel_mm: float = 0.5
    """Width of a pixel of the chart: half of what a pixel of a picture shows at arm's length."""
    around_mm: float = 6.0
    """Deviation of the window whose mean and contrast pictures are freed of."""
    faint: float = 3.0
    """Contrast (grey levels of 255) that counts half: below it there is noise."""


def normalised(grey: Float[np.ndarray, "h w"], config: LookConfig) -> Float32[np.ndarray, "h w"]:
    """The picture less its mean round about, over its contrast there; NaN where either is not known."""
    known = np.isfinite(grey)
    sigma = config.around_mm / config.pixel_mm
    fine = np.where(known, grey - averaged(grey, known, sigma), 0.0)
    contrast = np.sqrt(averaged(fine**2, known, sigma))
    return np.where(known & (contrast > BLANK), fine / (contrast + config.faint), np.nan).astype(np.float32)


def calm_reference(frames: Sequence[ChartedFrame], config: LookConfig) -> Float32[np.ndarray, "h w"]:
    """What skin looks like at rest: the median, NaN where less than half of the frames show it."""
    shown = np.stack([normalised(frame.grey, config) for frame in frames])
    known = np.isfinite(shown).mean(axis=0) >= 0.5
    shown[:, ~known] = 0.0
    return np.where(known, np.nanmedian(shown, axis=0), np.nan).astype(np.float32)
