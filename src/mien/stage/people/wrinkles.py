"""Wrinkles that come and go: patterns fixed on the skin, raised by compression as a buckling sheet is."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .fields import SmoothField, smooth_field
from .performer import smoothstep


@dataclass(frozen=True)
class FaceMap:
    """Where things are on one resting face, mm: what wrinkle patterns are drawn by."""

    eye: Float[np.ndarray, "2 3"]
    """Centres of the left and right eyeball."""
    canthus: Float[np.ndarray, "2 3"]
    """Outer corners of the eyes, left and right."""
    wing: Float[np.ndarray, "2 3"]
    """Outermost points of the nose's wings."""
    mouth: Float[np.ndarray, "2 3"]
    """Corners of the mouth."""
    chin: Float[np.ndarray, " 3"]
    """Foremost point of the chin."""


@dataclass(frozen=True)
class Pattern:
    """One group of wrinkles drawn on the resting skin."""

    name: str
    relief: Float[np.ndarray, " n"]
    """Height at full amplitude 1, furrows negative; 0 where the group is not."""
    direction: Float[np.ndarray, "n 3"]
    """Across the furrows: compression along this raises them."""
    threshold: float
    """Compression at which the skin buckles."""
    depth: float
    """Largest amplitude, mm."""
    permanent: float
    """Share of it that is always there."""


def buckling(compression: Float[np.ndarray, "*n"], threshold: float) -> Float[np.ndarray, "*n"]:
    """Amplitude of a buckled sheet, 0 to 1: none below the threshold, then as the root of what is beyond it.

    A thin sheet on a soft bed stays flat up to a critical strain e0 and then folds with amplitude ~ sqrt(e - e0)
    (Euler's pitchfork); skin's own stiffness makes it level off.
    """
    return np.tanh(np.sqrt(np.maximum(compression - threshold, 0.0) / 0.09))


def patterns(points: Float[np.ndarray, "n 3"], where: FaceMap, rng: np.random.Generator) -> list[Pattern]:
    """A person's wrinkles on the resting skin `points` (n, 3): where, how wide apart, how deep is up to chance."""
    out = [_forehead(points, where, rng), _glabella(points, where, rng), _nose(points, where, rng)]
    out += [_crows_feet(points, where, i, rng) for i in (0, 1)]
    out += [_nasolabial(points, where, i, rng) for i in (0, 1)]
    return [*out, _chin(points, where, rng)]


def furrows(phase: Float[np.ndarray, " n"], sharpness: float = 5.0) -> Float[np.ndarray, " n"]:
    """A periodic profile of mean 0: narrow furrows (-1 at phase 0, 2 pi, ...) between broad folds."""
    t = np.linspace(0, 2 * np.pi, 721)[:-1]
    mean = float(((0.5 + 0.5 * np.cos(t)) ** sharpness).mean())
    return (mean - (0.5 + 0.5 * np.cos(phase)) ** sharpness) / (1 - mean)


def _broken(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Lines are not equally deep all along: 0.4 to 1.2."""
    return np.clip(0.8 + 0.35 * _noise(points, rng, (14.0, 40.0)), 0.3, 1.2)


def _noise(points: np.ndarray, rng: np.random.Generator, wavelength: tuple[float, float]) -> np.ndarray:
    field: SmoothField = smooth_field(rng, wavelength)
    return field.at(points)[:, 0]


def _forehead(points: np.ndarray, where: FaceMap, rng: np.random.Generator) -> Pattern:
    """Three to five lines across, arched over the brows."""
    middle = where.eye.mean(axis=0)
    x, y = points[:, 0], points[:, 1] - middle[1]
    spacing = rng.uniform(9.5, 13.0)
    mask = smoothstep((y - 24) / 8) * smoothstep((76 - y) / 10) * smoothstep((62 - np.abs(x)) / 22)
    mask *= points[:, 2] > 40
    arch = 4.0 * np.cos(x / 20.0) * np.exp(-((x / 55) ** 2))
    phase = 2 * np.pi * (y + arch + 2.2 * _noise(points, rng, (30.0, 70.0))) / spacing
    relief = mask * furrows(phase) * _broken(points, rng)
    return Pattern("forehead", relief, np.tile([0.0, 1.0, 0.0], (len(points), 1)), 0.03, rng.uniform(0.6, 1.0), 0.06)


def _glabella(points: np.ndarray, where: FaceMap, rng: np.random.Generator) -> Pattern:
    """Two upright furrows between the brows, leaning outwards at the top, and a weaker one in the middle."""
    middle = where.eye.mean(axis=0)
    x, y = points[:, 0], points[:, 1] - middle[1] - 17
    mask = np.exp(-((x / 13) ** 4) - ((y / 15) ** 4)) * (points[:, 2] > 60)
    lean = 0.12 * y * np.sign(x)
    phase = 2 * np.pi * (np.abs(x) - lean + 0.8 * _noise(points, rng, (15.0, 30.0))) / rng.uniform(10.0, 13.0) + np.pi
    relief = mask * furrows(phase, 4.0) * _broken(points, rng)
    return Pattern("glabella", relief, np.tile([1.0, 0.0, 0.0], (len(points), 1)), 0.03, rng.uniform(0.5, 0.9), 0.06)


def _nose(points: np.ndarray, where: FaceMap, rng: np.random.Generator) -> Pattern:
    """Lines across the root of the nose, running down and out along its sides."""
    middle = where.eye.mean(axis=0)
    x, y = points[:, 0], points[:, 1] - middle[1] + 6
    mask = np.exp(-((x / 15) ** 4) - ((y / 11) ** 4)) * (points[:, 2] > middle[2] + 5)
    phase = 2 * np.pi * (y + 0.45 * np.abs(x) + 0.7 * _noise(points, rng, (12.0, 25.0))) / rng.uniform(5.5, 7.0)
    relief = mask * furrows(phase, 3.0) * _broken(points, rng)
    return Pattern("nose", relief, np.tile([0.0, 1.0, 0.0], (len(points), 1)), 0.03, rng.uniform(0.3, 0.5), 0.03)


def _crows_feet(points: np.ndarray, where: FaceMap, side: int, rng: np.random.Generator) -> Pattern:
    """A fan of lines from the outer corner of an eye."""
    sign = 1.0 if side == 0 else -1.0
    d = points - where.canthus[side]
    out, up = sign * d[:, 0] - 0.6 * np.minimum(d[:, 2], 0), d[:, 1]
    radius, angle = np.hypot(out, up), np.arctan2(up, out)
    near = (sign * points[:, 0] > 0) & (points[:, 2] > 20)
    mask = smoothstep((radius - 4) / 5) * smoothstep((34 - radius) / 14) * near
    mask *= smoothstep((1.0 - np.abs(angle)) / 0.35)
    phase = 2 * np.pi * (angle + 0.06 * _noise(points, rng, (12.0, 30.0))) / np.radians(rng.uniform(17, 23))
    relief = mask * furrows(phase, 3.0) * _broken(points, rng) * np.clip(radius / 12, 0.4, 1)
    across = np.stack([-sign * np.sin(angle), np.cos(angle), np.zeros(len(points))], axis=1)
    return Pattern(f"crow's foot {'LR'[side]}", relief, across, 0.04, rng.uniform(0.35, 0.6), 0.08)


def _nasolabial(points: np.ndarray, where: FaceMap, side: int, rng: np.random.Generator) -> Pattern:
    """The fold from a wing of the nose past the corner of the mouth: one furrow, the cheek bulging beside it."""
    sign = 1.0 if side == 0 else -1.0
    start = where.wing[side] + [sign * 2.0, 4.0, 0.0]
    end = where.mouth[side] + [sign * 9.0, -7.0, 0.0]
    along = np.clip((points[:, 1] - end[1]) / (start[1] - end[1]), -0.2, 1.2)
    bow = 3.0 * np.clip(1 - (2 * along - 1) ** 2, 0, 1)
    line = sign * (end[0] + (start[0] - end[0]) * along) + bow
    beside = sign * points[:, 0] - line + 0.6 * _noise(points, rng, (15.0, 40.0))
    ends = smoothstep((along + 0.15) / 0.3) * smoothstep((1.12 - along) / 0.25)
    shape = 0.55 * np.exp(-(((beside - 6) / 4.5) ** 2)) - np.exp(-((beside / 1.9) ** 2))
    relief = shape * ends * (points[:, 2] > 50) * (sign * points[:, 0] > 5)
    across = np.tile([sign * 0.8, 0.6, 0.0], (len(points), 1))
    return Pattern(f"nasolabial {'LR'[side]}", relief, across, 0.04, rng.uniform(0.7, 1.0), 0.12)


def _chin(points: np.ndarray, where: FaceMap, rng: np.random.Generator) -> Pattern:
    """Pebbles where the chin's muscle bunches the skin."""
    d = points - where.chin
    mask = np.exp(-((d[:, 0] / 16) ** 4) - (((d[:, 1] - 8) / 10) ** 4)) * (points[:, 2] > 60)
    relief = mask * np.clip(_noise(points, rng, (4.0, 7.5)), -1.5, 1.0)
    return Pattern("chin", relief, np.tile([0.0, 1.0, 0.0], (len(points), 1)), 0.05, rng.uniform(0.2, 0.35), 0.05)
