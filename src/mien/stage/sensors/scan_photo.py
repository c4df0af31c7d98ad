"""What colours a scanner writes: the skin's, under a light and through a camera of that scan's own."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .worn import HAIR_COLOUR

GAMMA = 2.2
"""Of the colours' encoding, nearly sRGB's."""


@dataclass(frozen=True)
class PhotoConfig:
    """What differs between the colours of one scan and the next. All zeros: flat white light, no noise."""

    exposure: float = 0.0
    """Standard deviation of a scan's exposure, stops. 0: all alike."""
    white_balance: float = 0.0
    """Standard deviation of the logarithm of a scan's gain a channel. 0: all alike."""
    shading: float = 0.0
    """How much a lamp of the scan's own darkens what it does not face, share. 0: flat light."""
    noise: float = 0.0
    """Standard deviation of a colour channel's noise, of 255. 0: none."""


def photographed(
    paint: Float[np.ndarray, "p 3"],
    normals: Float[np.ndarray, "p 3"],
    hair: Float[np.ndarray, " p"],
    config: PhotoConfig,
    rng: np.random.Generator,
) -> Float[np.ndarray, "p 3"]:
    """Colours in 0..1 (sRGB) of skin `paint` under hair of a height `hair`, mm, as one scan sees them."""
    covered = np.clip(hair, 0, 1)[:, None] * 0.8
    seen = paint * (1 - covered) + HAIR_COLOUR * covered
    lamp = np.array([rng.normal(), 0.5 + 0.3 * rng.normal(), 1.0])
    facing = np.clip(normals @ (lamp / np.linalg.norm(lamp)), 0, 1)
    gain = 2.0 ** (config.exposure * rng.normal()) * np.exp(config.white_balance * rng.normal(size=3))
    linear = seen**GAMMA * gain * (1 - config.shading * (1 - facing))[:, None]
    noise = config.noise / 255 * rng.normal(size=paint.shape)
    return np.clip(linear ** (1 / GAMMA) + noise, 0.0, 1.0)
