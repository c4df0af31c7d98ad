"""How far the skin has slipped along the tracked face: optical flow on the chart, from the calm frames, in mm."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Float32

from ...flow import FlowConfig, optical_flow
from ...image_space.features import averaged
from ...image_space.layout import sampled
from .front_chart import ChartedFrame, FrontChart

BLANK = 0.5
"""Contrast (grey levels of 255) below which a picture shows nothing."""


@dataclass(frozen=True)
class SlipConfig:
    """The chart and the flow on it."""

    pixel_mm: float = 0.5
    """Width of a pixel of the chart. A whole mm, about what a pixel of a picture shows at arm's length, costs half as
    much and brings half as much."""
    around_mm: float = 6.0
    """Deviation of the window whose mean and contrast pictures are freed of."""
    faint: float = 3.0
    """Contrast (grey levels of 255) that counts half: below it there is noise."""
    average_mm: float = 5.0
    """Deviation of the window that flow is averaged over."""
    most_mm: float = 6.0
    """Flow is cut to this length."""
    flow: FlowConfig = field(default_factory=lambda: FlowConfig(margin=8))
    """The optical flow, in pixels of the chart."""


def normalised(grey: Float[np.ndarray, "h w"], config: SlipConfig) -> Float32[np.ndarray, "h w"]:
    """The picture less its mean round about, over its contrast there; NaN where either is not known."""
    known = np.isfinite(grey)
    sigma = config.around_mm / config.pixel_mm
    fine = np.where(known, grey - averaged(grey, known, sigma), 0.0)
    contrast = np.sqrt(averaged(fine**2, known, sigma))
    return np.where(known & (contrast > BLANK), fine / (contrast + config.faint), np.nan).astype(np.float32)


def calm_reference(frames: Sequence[ChartedFrame], config: SlipConfig) -> Float32[np.ndarray, "h w"]:
    """What skin looks like at rest: the median, NaN where less than half of the frames show it."""
    shown = np.stack([normalised(frame.grey, config) for frame in frames])
    known = np.isfinite(shown).mean(axis=0) >= 0.5
    shown[:, ~known] = 0.0
    return np.where(known, np.nanmedian(shown, axis=0), np.nan).astype(np.float32)


def skin_slip(
    chart: FrontChart, frame: ChartedFrame, reference: Float32[np.ndarray, "h w"], config: SlipConfig
) -> Float32[np.ndarray, "f 3"]:
    """From where the model puts each vertex to where its skin is seen, mm along the surface; 0 where it is not."""
    picture = normalised(frame.grey, config)
    both = np.isfinite(picture) & np.isfinite(reference)
    out = np.zeros((len(chart.uv), 3), np.float32)
    if not both.any():
        return out
    found = optical_flow(reference, picture, both, config=config.flow).flow
    sigma = config.average_mm / config.pixel_mm
    flow = np.stack([averaged(found[..., axis], both, sigma) for axis in (0, 1)], axis=-1)
    flow = _cut(flow, config.most_mm / config.pixel_mm)
    moved = chart.uv + sampled(flow, chart.uv)
    seen = chart.shown & (_known_at(both, chart.uv) & _known_at(both, moved))
    step = sampled(frame.surface, moved) - sampled(frame.surface, chart.uv)
    out[seen] = step[seen]
    return out


def _cut(flow: Float[np.ndarray, "h w 2"], most: float) -> Float[np.ndarray, "h w 2"]:
    size = np.linalg.norm(flow, axis=-1, keepdims=True)
    return flow * (most / np.maximum(size, most))


def _known_at(mask: np.ndarray, places: Float[np.ndarray, "f 2"]) -> np.ndarray:
    """Whether all pixels round a place are in the mask."""
    return sampled(mask.astype(np.float64), places)[..., 0] > 0.99
