"""What the projector and the lamps show, slot by slot, as images and as a list that names them."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float, Float32, Int, Real

from ..errors import BadInput
from ..files import existing, whole

Kind = Literal["full", "black", "sinusoid", "gray", "gray_inverse", "ramp", "gradient", "constant", "tracking"]
PROJECTED = ("full", "black", "sinusoid", "gray", "gray_inverse", "ramp")
"""Kinds that a projector shows; the others are conditions of lamps round the subject."""
FINEST_PIXELS = 16.0
"""Projector pixels in a period of the finest sinusoid: shorter ones drown in the blur of lens and skin."""
SINUSOIDS = 6
"""As in the paper."""
GOLDEN = 2.399963
"""Phases of one sinusoid after another differ by the golden angle, so that their folds do not meet, radians."""


@dataclass(frozen=True)
class LightPattern:
    """One slot of a capture."""

    kind: Kind
    axis: Literal["x", "y", "z", ""] = ""
    """Along which the pattern changes: x and y of the projector's image; x, y, z of a gradient in the rig's frame."""
    periods: float = 0.0
    """Of a sinusoid, over the whole width or height."""
    phase: float = 0.0
    """Of a sinusoid at the image's edge, radians."""
    bit: int = 0
    """Of a Gray code, 0 the coarsest; of a ramp, which level."""
    level: float = 1.0
    """Of a ramp, 0..1."""


@dataclass(frozen=True)
class PatternSet:
    """The slots of one capture in their order."""

    patterns: tuple[LightPattern, ...]
    width: int
    """Of the projector, pixels."""
    height: int
    rate: float = 360.0
    """Slots a second."""

    def __len__(self) -> int:
        return len(self.patterns)

    def __repr__(self) -> str:
        kinds = [pattern.kind for pattern in self.patterns]
        counts = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
        return f"PatternSet({counts}; {self.width} x {self.height}, {self.rate:g}/s)"

    def of(self, *kinds: Kind, axis: str | None = None) -> list[int]:
        """Slots of these kinds (and, if told, of this axis)."""
        return [i for i, p in enumerate(self.patterns) if p.kind in kinds and axis in (None, p.axis)]

    def one(self, kind: Kind) -> int:
        """The only slot of a kind.

        Raises:
            BadInput: none, or several.
        """
        slots = self.of(kind)
        if len(slots) != 1:
            raise BadInput(f"patterns: expected one {kind} slot, got {len(slots)}")
        return slots[0]

    def image(self, slot: int) -> Float[np.ndarray, "h w"]:
        """What the projector shows, linear 0..1.

        Raises:
            BadInput: a condition of lamps, which no projector shows.
        """
        pattern = self.patterns[slot]
        if pattern.kind not in PROJECTED:
            raise BadInput(f"pattern {slot}: {pattern.kind} is a condition of lamps; a projector shows none")
        if pattern.axis == "y":
            return np.repeat(profile(pattern, self.height)[:, None], self.width, axis=1)
        return np.repeat(profile(pattern, self.width)[None], self.height, axis=0)


def profile(pattern: LightPattern, size: int) -> Float[np.ndarray, " size"]:
    """A pattern along its axis, at pixel centres, linear 0..1."""
    pixels = np.arange(size)
    if pattern.kind == "sinusoid":
        return sinusoid(pattern, pixels, size)
    if pattern.kind in ("gray", "gray_inverse"):
        code = pixels ^ (pixels >> 1)
        bit = (code >> (bits_of(size) - 1 - pattern.bit)) & 1
        return (1 - bit if pattern.kind == "gray_inverse" else bit).astype(float)
    level = {"black": 0.0, "full": 1.0}.get(pattern.kind, pattern.level)
    return np.full(size, level)


def sinusoid(pattern: LightPattern, pixel: Real[np.ndarray, "*n"], size: int) -> Float[np.ndarray, "*n"]:
    """(1 + cos(2 pi f u + phi)) / 2, u running from 0 to 1 over the image's edges."""
    return (1 + np.cos(2 * np.pi * pattern.periods * (pixel + 0.5) / size + pattern.phase)) / 2


def sinusoid_tables(
    waves: tuple[LightPattern, ...], size: int, steps: Int[np.ndarray, " levels"], per_pixel: int
) -> Float32[np.ndarray, "levels k n"]:
    """All patterns at `per_pixel` entries a pixel, of which each level has every so many; infinite beyond the image."""
    entries = per_pixel * size
    tables = np.full((len(steps), len(waves), -(-entries // int(steps.min()))), np.inf, np.float32)
    for level, step in enumerate(steps):
        pixels = (np.arange(0, entries, step) + 0.5) / per_pixel - 0.5
        for k, wave in enumerate(waves):
            tables[level, k, : len(pixels)] = sinusoid(wave, pixels, size)
    return tables


def bits_of(size: int) -> int:
    """Gray-code images that tell `size` pixels apart."""
    return int(np.ceil(np.log2(size)))


def paper_set(width: int, height: int, rate: float = 360.0) -> PatternSet:
    """The paper's twelve slots: six sinusoids, full-on, four gradients (the constant one first), the tracking frame.

    The coarsest sinusoid spans half a period, so that no two columns share its value; the others grow by one factor,
    and the finest is shown twice, a quarter of a period apart: where one is flat the other is steep.
    """
    finest = max(width / FINEST_PIXELS, 1.0)
    periods = 0.5 * (finest / 0.5) ** (np.arange(SINUSOIDS - 1) / (SINUSOIDS - 2))
    waves = [LightPattern("sinusoid", "x", float(f), 0.0 if k == 0 else k * GOLDEN) for k, f in enumerate(periods)]
    waves.append(LightPattern("sinusoid", "x", float(periods[-1]), waves[-1].phase + np.pi / 2))
    gradients = [LightPattern("gradient", axis) for axis in ("x", "y", "z")]
    return PatternSet(
        (*waves, LightPattern("full"), LightPattern("constant"), *gradients, LightPattern("tracking")),
        width,
        height,
        rate,
    )


def phase_set(
    width: int, height: int, steps: int = 4, finest_pixels: float = 32.0, rate: float = 360.0, rounds: int = 1
) -> PatternSet:
    """N-step phase shift along x, unwrapped by a Gray code of the same axis; a full-on and a black frame.

    Args:
        rounds: how often the steps are shown; from two on, what moves meanwhile leaves few waves.

    Raises:
        BadInput: fewer than three steps, or no round.
    """
    if rounds < 1:
        raise BadInput(f"phase shift: expected 1 round of steps or more, got {rounds}")
    if steps < 3:
        raise BadInput(f"phase shift: expected 3 steps or more, got {steps}")
    waves = [LightPattern("sinusoid", "x", width / finest_pixels, 2 * np.pi * k / steps) for k in range(steps)] * rounds
    return PatternSet(
        (*waves, *gray_code("x", width), LightPattern("full"), LightPattern("black")), width, height, rate
    )


def moving_phase_set(width: int, height: int) -> PatternSet:
    """A phase shift for what moves: two rounds of four steps."""
    return phase_set(width, height, rounds=2)


def gray_set(width: int, height: int, rate: float = 360.0) -> PatternSet:
    """Gray codes of both axes, each image followed by its inverse; a full-on and a black frame."""
    codes = (*gray_code("x", width), *gray_code("y", height))
    return PatternSet((*codes, LightPattern("full"), LightPattern("black")), width, height, rate)


def ramp_set(width: int, height: int, levels: int = 9, rate: float = 360.0) -> PatternSet:
    """Even grey levels from black to white: how linear projector and camera are."""
    steps = np.linspace(0.0, 1.0, levels)
    return PatternSet(
        tuple(LightPattern("ramp", bit=i, level=float(v)) for i, v in enumerate(steps)), width, height, rate
    )


def gray_code(axis: Literal["x", "y"], size: int) -> tuple[LightPattern, ...]:
    """The bits of an axis, coarse to fine, each followed by its inverse."""
    kinds: tuple[Kind, Kind] = ("gray", "gray_inverse")
    return tuple(LightPattern(kind, axis, bit=b) for b in range(bits_of(size)) for kind in kinds)


def write_patterns(path: str | Path, patterns: PatternSet) -> None:
    """The list that names the slots, as JSON."""
    with whole(path) as temporary:
        temporary.write_text(json.dumps(asdict(patterns), indent=1))


def read_patterns(path: str | Path) -> PatternSet:
    """A list that `write_patterns` has left.

    Raises:
        BadInput: no such list, or not one of patterns.
    """
    path = existing(path)
    try:
        told = json.loads(path.read_text())
        slots = tuple(LightPattern(**slot) for slot in told.pop("patterns"))
        made = PatternSet(slots, **told)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadInput(f"{path}: no list of patterns ({error}); write one by `mien decode --show paper`") from None
    known = Kind.__args__
    odd = [p.kind for p in slots if p.kind not in known]
    if odd or not slots:
        raise BadInput(f"{path}: unknown pattern {odd[0]!r}" if odd else f"{path}: no patterns")
    return made
