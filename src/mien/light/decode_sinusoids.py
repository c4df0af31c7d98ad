"""Projector columns from the ratios of sinusoids to the full-on pattern (sec. 3), by maximum likelihood.

The ratio r = (1 + cos(2 pi f u + phi)) / 2 is even in the phase: one pattern tells u only up to folds, all together do.
min_u sum_k (r_k - r_k(u))^2 / sigma_k^2, searched coarse to fine, then polished by Gauss-Newton.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from .._kernels import sinusoids as kernel
from .._kernels._spread import spread
from ..errors import BadInput
from ..image_space.window import GaussianWindow
from .motion import at_slot
from .patterns import LightPattern, PatternSet, sinusoid_tables

MANY_PERIODS = 4.0
"""Patterns with more periods than this show whole ones on a face, so that their contrast can be told."""
POLISH_ROUNDS = 3, 1
"""Of Gauss-Newton, from an estimate within half an entry of the table; and from the last estimate."""
SEARCH_STEPS = 24
"""Entries that are tried in a period of a level's finest pattern."""
CONTRAST_RANGE = (0.05, 1.2)
"""Of a local contrast."""


@dataclass(frozen=True)
class DecodeConfig:
    """How patterns are read."""

    noise: float = 0.006
    """Standard deviation of a pixel, share of full scale: that of 8 bits and a fast camera."""
    darkest: float = 0.04
    """Pixels whose full-on value (black taken off) is below this share of full scale are in shadow."""
    brightest: float = 0.99
    """Pixels above this in any frame are saturated."""
    worst: float = 25.0
    """Pixels whose mean squared residual is above this many variances (beside the median's) are left out."""
    per_pixel: int = 2
    """Entries of the search table a projector pixel."""
    border_px: int = 2
    """Pixels so near the edge of what is lit are left out: light bleeds across it."""
    window_px: float = 12.0
    """Standard deviation of the window over which contrast and drift are measured, pixels."""
    rounds: int = 2
    """How often. Skin blurs fine patterns more where they fall at a slant. 0: one contrast a pattern, no drift."""
    motion: bool = True
    """Find how columns drift while patterns change (past the paper, which leaves motion in the structured light)."""
    fold: float = 1.0
    """How far round a level's estimate the next one searches, in periods of the coarser pattern."""
    search_sigma: float = 0.05
    """Standard deviation of a ratio in the search: half a step of its table and unknown room light, far above noise."""


@dataclass(frozen=True)
class Decoded:
    """Where on the projector's axis each camera pixel looks."""

    pixel: Float[np.ndarray, "h w"]
    """Projector pixel, sub-pixel, NaN where nothing is known."""
    sigma: Float[np.ndarray, "h w"]
    """Standard deviation of it, projector pixels."""
    contrast: tuple[float, ...] = ()
    """Of each pattern, 1 without blur: how much of the projected swing comes back."""
    misfit: float = 0.0
    """Median over pixels of the mean squared residual in variances: near 1 where patterns and noise are as told."""

    @property
    def known(self) -> Bool[np.ndarray, "h w"]:
        """Where it is known."""
        return np.isfinite(self.pixel)


@dataclass(frozen=True)
class Ratios:
    """What the lit pixels of a capture show of each sinusoid, coarse to fine."""

    lit: Bool[np.ndarray, "h w"]
    values: Float[np.ndarray, "p k"]
    """Sinusoid to full-on, black taken off both."""
    variance: Float[np.ndarray, "p k"]
    contrast: Float[np.ndarray, "p k"]
    """Of the swing."""
    lags: Float[np.ndarray, " k"]
    """Slots after the moment of `structured_moment`."""
    waves: tuple[LightPattern, ...]
    width: int
    """Of the projector, pixels."""

    @property
    def rates(self) -> Float[np.ndarray, " k"]:
        """Radians a column."""
        return np.array([2 * np.pi * wave.periods / self.width for wave in self.waves])

    @property
    def shifts(self) -> Float[np.ndarray, " k"]:
        """Radians at column 0."""
        return np.array([wave.phase for wave in self.waves]) + self.rates / 2


@dataclass(frozen=True)
class Polished:
    """Columns of the lit pixels after Gauss-Newton."""

    columns: Float[np.ndarray, " p"]
    sigma: Float[np.ndarray, " p"]
    misfit: Float[np.ndarray, " p"]
    """Mean squared residual, in variances."""


def decode_sinusoids(
    images: Float[np.ndarray, "slots h w"],
    patterns: PatternSet,
    config: DecodeConfig = DecodeConfig(),
    flow: Float[np.ndarray, "h w 2"] | None = None,
) -> Decoded:
    """Columns of the projector, from all slots of one capture, linear 0..1.

    Without a black frame ambient light is taken for the pattern's own: it pulls ratios towards one another, and columns
    with them.

    Args:
        flow: how far back each pixel was one slot earlier (`motion.slot_flow`): the full-on pattern's picture goes with
            the skin to each sinusoid's slot, so that a dot or a brow that moves is no pattern. None: nothing moves.

    Raises:
        BadInput: no sinusoids, or a picture in which the projector lights nothing.
    """
    ratios = measured_ratios(images, patterns, config, flow)
    start = search(ratios, config)
    drift = np.zeros_like(start)
    found = polish(start, drift, ratios, POLISH_ROUNDS[0])
    window = GaussianWindow(ratios.lit, config.window_px)
    for _ in range(config.rounds):
        ratios = replace(ratios, contrast=local_contrasts(found.columns, drift, ratios, window))
        if config.motion:
            drift = drift + local_drift(found.columns, drift, ratios, window)
        found = polish(found.columns, drift, ratios, POLISH_ROUNDS[1])
    typical = float(np.median(found.misfit))
    inside = (found.columns > -0.5) & (found.columns < patterns.width - 0.5)
    sound = (found.misfit < config.worst * max(typical, 1.0)) & inside
    pixel, sigma = (masked_image(np.where(sound, v, np.nan), ratios.lit) for v in (found.columns, found.sigma))
    contrast = tuple(float(c) for c in np.median(ratios.contrast, axis=0))
    return Decoded(pixel, sigma, contrast, typical)


def structured_moment(patterns: PatternSet) -> float:
    """The slot whose moment columns show: the mean of the finest sinusoids, which fix them, and the full-on pattern."""
    periods = {slot: patterns.patterns[slot].periods for slot in patterns.of("sinusoid", axis="x")}
    finest = [slot for slot, f in periods.items() if np.isclose(f, max(periods.values()))]
    return float(np.mean([*finest, patterns.one("full")]))


def measured_ratios(
    images: Float[np.ndarray, "slots h w"],
    patterns: PatternSet,
    config: DecodeConfig,
    flow: Float[np.ndarray, "h w 2"] | None = None,
) -> Ratios:
    """Sinusoids over the full-on pattern where that lights anything.

    Raises:
        BadInput: fewer than three sinusoids, or nothing lit.
    """
    slots = patterns.of("sinusoid", axis="x")
    if len(slots) < 3:
        raise BadInput(f"patterns: expected 3 sinusoids of several periods or more, got {len(slots)}")
    slots = sorted(slots, key=lambda slot: patterns.patterns[slot].periods)
    lit, black = lit_pixels(images, patterns, slots, config)
    if config.border_px:
        lit = np.asarray(ndimage.binary_erosion(lit, iterations=config.border_px), dtype=bool)
    waves = tuple(patterns.patterns[slot] for slot in slots)
    full = patterns.one("full")
    gain = images[full] - black
    moved = [gain if flow is None else at_slot(gain, flow, slot - full) for slot in slots]
    gains = np.stack([np.asarray(picture, dtype=float)[lit] for picture in moved], 1)
    gains = np.maximum(gains, config.darkest / 2)
    values = np.stack([(images[slot] - black)[lit] for slot in slots], 1) / gains
    variance = (config.noise / gains) ** 2 * (1 + values**2)
    contrast = np.broadcast_to(contrasts(values, waves), values.shape).copy()
    lags = np.array(slots) - structured_moment(patterns)
    return Ratios(lit, values, variance, contrast, lags, waves, patterns.width)


def lit_pixels(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, slots: list[int], config: DecodeConfig
) -> tuple[Bool[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """Pixels that the projector lights and that no frame saturates; and what is seen with the projector black.

    Raises:
        BadInput: there are none.
    """
    full = images[patterns.one("full")]
    black = images[patterns.one("black")] if patterns.of("black") else np.zeros_like(full)
    bright = np.maximum(images[slots].max(axis=0), full)
    lit = (full - black > config.darkest) & (bright < config.brightest)
    if not lit.any():
        why = "saturated" if (full >= config.brightest).mean() > 0.5 else "dark"
        raise BadInput(f"full-on pattern: no pixel is lit well, most are {why}; mend the exposure, or the slots' order")
    return lit, black


def contrasts(ratios: Float[np.ndarray, "p k"], waves: tuple[LightPattern, ...]) -> Float[np.ndarray, " k"]:
    """How much of its swing each sinusoid keeps: blur of lens and skin flattens the fine ones.

    Of a cosine of any phase, 95 % lie below 0.997 of the swing. Coarse patterns, of which a face shows a piece of a
    period only, are taken whole.
    """
    swing = np.quantile(np.abs(2 * ratios - 1), 0.95, axis=0) / np.cos(0.05 * np.pi / 2)
    many = np.array([wave.periods > MANY_PERIODS for wave in waves])
    return np.where(many, np.clip(swing, 0.05, 1.0), 1.0)


def search(ratios: Ratios, config: DecodeConfig) -> Float[np.ndarray, " p"]:
    """The likeliest column of a table, coarse to fine."""
    entries = config.per_pixel * ratios.width
    period = np.array([entries / wave.periods for wave in ratios.waves])
    steps = np.maximum(period / SEARCH_STEPS, 1).astype(np.int64)
    windows = np.append(entries, config.fold * period[:-1]).astype(np.int64)
    tables = sinusoid_tables(ratios.waves, ratios.width, steps, config.per_pixel)
    whole = 0.5 + (ratios.values - 0.5) / ratios.contrast
    precision = 1 / (ratios.variance / ratios.contrast**2 + config.search_sigma**2)
    best = np.zeros(len(whole), np.int64)

    def rows(first: int, last: int) -> None:
        p = slice(first, last)
        told = whole[p].astype(np.float32), precision[p].astype(np.float32)
        kernel.search_columns(*told, tables, steps, windows, best[p])

    spread(rows, len(whole))
    return (best + 0.5) / config.per_pixel - 0.5


def polish(
    columns: Float[np.ndarray, " p"], drift: Float[np.ndarray, " p"], ratios: Ratios, rounds: int = POLISH_ROUNDS[0]
) -> Polished:
    """Gauss-Newton on all patterns."""
    moved, sigma, misfit = columns.copy(), np.empty_like(columns), np.empty_like(columns)
    precision, waves = 1 / ratios.variance, (ratios.rates, ratios.shifts, ratios.lags)

    def rows(first: int, last: int) -> None:
        p = slice(first, last)
        told = (ratios.values[p], ratios.contrast[p], precision[p])
        kernel.polish_columns(moved[p], drift[p], *told, *waves, rounds, sigma[p], misfit[p])

    spread(rows, len(columns))
    return Polished(moved, sigma, misfit)


def local_contrasts(
    columns: Float[np.ndarray, " p"], drift: Float[np.ndarray, " p"], ratios: Ratios, window: GaussianWindow
) -> Float[np.ndarray, "p k"]:
    """What is left of each sinusoid's swing round every pixel: the regression of what is seen on what is expected.

    A contrast that is taken wrong pulls columns to and fro with the pattern's phase: stripes on the surface.
    """
    moments = np.empty((*ratios.values.shape, 2))
    waves = (ratios.rates, ratios.shifts, ratios.lags)

    def rows(first: int, last: int) -> None:
        p = slice(first, last)
        kernel.contrast_moments(columns[p], drift[p], ratios.values[p], *waves, moments[p])

    spread(rows, len(columns))
    many = np.array([wave.periods > MANY_PERIODS for wave in ratios.waves])
    seen, power = (window.sums(moments[:, many, i]) for i in (0, 1))
    out = np.ones_like(ratios.values)
    out[:, many] = window.at_pixels(np.clip(seen / np.maximum(power, 1e-9), *CONTRAST_RANGE))
    return out


def local_drift(
    columns: Float[np.ndarray, " p"], drift: Float[np.ndarray, " p"], ratios: Ratios, window: GaussianWindow
) -> Float[np.ndarray, " p"]:
    """How much faster than `drift` the column under each pixel changes, columns a slot: motion between patterns.

    Each pixel has a column of its own, its neighbourhood one drift: least squares in both, the columns eliminated.
    """
    moments = np.empty((len(columns), 2))
    precision, waves = 1 / ratios.variance, (ratios.rates, ratios.shifts, ratios.lags)

    def rows(first: int, last: int) -> None:
        p = slice(first, last)
        told = (columns[p], drift[p], ratios.values[p], ratios.contrast[p], precision[p])
        kernel.drift_moments(*told, *waves, moments[p])

    spread(rows, len(columns))
    sums = window.sums(moments)
    return window.at_pixels(sums[..., :1] / np.maximum(sums[..., 1:], 1e-12))[:, 0]


def masked_image(values: Float[np.ndarray, " p"], mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    """Values of masked pixels as an image, NaN elsewhere."""
    image = np.full(mask.shape, np.nan)
    image[mask] = values
    return image
