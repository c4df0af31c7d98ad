"""sRGB and linear light."""

import numpy as np
from jaxtyping import Float, UInt8


def to_linear(srgb: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    """sRGB 0..1 -> linear light 0..1 (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((np.maximum(srgb, 0.04045) + 0.055) / 1.055) ** 2.4)


def to_srgb(linear: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    """Linear light 0..1 -> sRGB 0..1; what lies outside is cut off."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def to_bytes(srgb: Float[np.ndarray, "*n"]) -> UInt8[np.ndarray, "*n"]:
    """0..1 -> 0..255, rounded."""
    return (np.clip(srgb, 0, 1) * 255 + 0.5).astype(np.uint8)


LINEAR_OF_BYTE = to_linear(np.arange(256) / 255).astype(np.float32)
"""Linear light of each sRGB level."""

LEVEL_OF_ROOT = (to_srgb(np.linspace(0, 1, 4096) ** 2) * 255).astype(np.float32)
"""sRGB level 0..255 of the linear light whose square root is the place in this table."""
