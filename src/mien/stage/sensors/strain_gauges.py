"""Strain gauges in a headset's lining: how far skin of brows, lids and cheeks is stretched, with noise and drift."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ...landmarks.detector import bundled_landmarks
from ..truth import Truth

SEGMENTS: dict[str, tuple[int, int]] = {
    "glabella": (107, 336),
    "brow_inner_left": (337, 336),
    "brow_inner_right": (108, 107),
    "brow_outer_left": (333, 334),
    "brow_outer_right": (104, 105),
    "lid_left": (386, 282),
    "lid_right": (159, 52),
    "cheek_left": (374, 330),
    "cheek_right": (145, 101),
}
"""Channels, and the landmarks between which each is glued."""


@dataclass(frozen=True)
class GaugeConfig:
    """The gauges' faults."""

    rate: float = 60.0
    """Readings a second; their clock is not the camera's."""
    noise: float = 0.004
    """Standard deviation, strain (0.01 is one per cent longer). 0: none."""
    drift: float = 0.01
    """How far a reading wanders in a minute, strain, as a random walk. 0: not at all."""
    fit: float = 0.02
    """A session's readings at rest differ by so much from another's: the headset sits anew. 0: not at all."""


@dataclass(frozen=True)
class GaugeReadings:
    """What the gauges told."""

    times: Float[np.ndarray, " r"]
    """Seconds from the take's first frame."""
    names: tuple[str, ...]
    values: Float[np.ndarray, "r channels"]
    """Strain."""


def strain_readings(truth: Truth, config: GaugeConfig = GaugeConfig(), seed: int = 0) -> GaugeReadings:
    """The gauges over a performance; between two frames they read what lies between."""
    rng = np.random.default_rng([seed, 31])
    ends = np.array(list(SEGMENTS.values()))
    attachment = bundled_landmarks().attachment
    exact = []
    for shape in (truth.neutral.vertices, *truth.vertices()):
        points = attachment.points(truth.neutral.with_vertices(shape))
        exact.append(np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1))
    strain = np.array(exact[1:]) / exact[0] - 1.0
    frames = np.arange(len(truth)) / truth.rate
    times = np.arange(0.0, frames[-1] + 1e-9, 1.0 / config.rate)
    read = np.stack([np.interp(times, frames, column) for column in strain.T], axis=1)
    a_step = config.drift / np.sqrt(60.0 * config.rate)
    read += np.cumsum(rng.normal(0, a_step, read.shape), axis=0)
    read += rng.normal(0, config.fit, read.shape[1]) + rng.normal(0, config.noise, read.shape)
    return GaugeReadings(times, tuple(SEGMENTS), read)
