"""Smooth random fields over space: what makes one person's face and expressions their own."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class SmoothField:
    """A sum of plane waves: c channels, zero mean and unit variance over space, defined at every point."""

    wave_vectors: Float[np.ndarray, "waves 3"]
    """Radians a millimetre."""
    phases: Float[np.ndarray, " waves"]
    amplitudes: Float[np.ndarray, "waves channels"]

    def at(self, points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n channels"]:
        """Values at `points` (n, 3), millimetres."""
        angles = (points @ self.wave_vectors.T + self.phases).astype(np.float32)
        return (np.cos(angles) @ self.amplitudes.astype(np.float32)).astype(np.float64)


def smooth_field(
    rng: np.random.Generator, wavelength: tuple[float, float], channels: int = 1, waves: int = 16
) -> SmoothField:
    """A random field whose waves are between the two lengths of `wavelength` (shortest, longest), millimetres."""
    directions = rng.normal(size=(waves, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    lengths = np.exp(rng.uniform(*np.log(wavelength), size=waves))
    amplitudes = rng.normal(size=(waves, channels))
    amplitudes *= np.sqrt(2.0 / (amplitudes**2).sum(axis=0))
    return SmoothField(2 * np.pi * directions / lengths[:, None], rng.uniform(0, 2 * np.pi, waves), amplitudes)


def mirrored_points(points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """The points' places on the other side of the face (x turned round)."""
    return points * [-1.0, 1.0, 1.0]


def paired_field(
    rng: np.random.Generator,
    points: Float[np.ndarray, "n 3"],
    wavelength: tuple[float, float],
    mirror: Float[np.ndarray, " channels"],
    asymmetry: float,
) -> tuple[Float[np.ndarray, "n channels"], Float[np.ndarray, "n channels"]]:
    """One random field as the left side of a person wears it, and the right side's nearly mirrored one.

    Args:
        mirror: sign of each channel in a mirror: 1 for a scalar, (-1, 1, 1) for a displacement, (1, -1, -1) for a
            rotation vector.
        asymmetry: 0 for a perfectly mirrored person, 1 for sides that have nothing in common.
    """
    channels = len(mirror)
    shared = smooth_field(rng, wavelength, channels)
    own_left, own_right = (smooth_field(rng, wavelength, channels).at(points) for _ in range(2))
    keep = np.sqrt(1.0 - asymmetry**2)
    left = keep * shared.at(points) + asymmetry * own_left
    right = keep * shared.at(mirrored_points(points)) * mirror + asymmetry * own_right
    return left, right


def symmetric_field(
    rng: np.random.Generator,
    points: Float[np.ndarray, "n 3"],
    wavelength: tuple[float, float],
    mirror: Float[np.ndarray, " channels"],
    asymmetry: float,
) -> Float[np.ndarray, "n channels"]:
    """A random field that is nearly its own mirror image; arguments as `paired_field`."""
    field = smooth_field(rng, wavelength, len(mirror))
    both = (field.at(points) + field.at(mirrored_points(points)) * mirror) / np.sqrt(2)
    own = smooth_field(rng, wavelength, len(mirror)).at(points)
    return np.sqrt(1.0 - asymmetry**2) * both + asymmetry * own
