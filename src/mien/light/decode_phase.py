"""Projector pixels from N-step phase shifts and Gray codes: what most people's projectors show."""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float
from scipy import ndimage
from scipy.sparse import csgraph

from ..errors import BadInput
from .decode_sinusoids import DecodeConfig, Decoded, lit_pixels
from .patterns import PatternSet, bits_of

CLEAR = 0.04
"""A Gray bit is clear where pattern and inverse differ by this share of full scale. One may be unclear: between two
pixels of the projector a single bit changes, and either value is right to a pixel."""
APART = 1 / 10
"""Of a period, median between phase and code, from which on they have nothing to do with one another: that comes to
1 / 8 for two swapped steps of four, and to 1 / 4 at random."""
WAVES = 3
"""Harmonics of a period that are evened out: three steps leave gamma's waves at the third."""
MOST_STEPS = 8
"""Of a round, whose neighbours take motion out; with more the binomial factors below add more noise than they take."""
WINDOW = 5
"""Pixels a side over which whole-pixel codes are averaged: the plane through them, at its centre."""


def wrapped_phase(
    images: Float[np.ndarray, "n h w"], phases: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """Phase in -pi..pi and amplitude of `A + B cos(phase + phases[k])`, by least squares over the steps.

    Raises:
        BadInput: steps that do not tell the three unknowns apart.
    """
    design = np.stack([np.ones_like(phases), np.cos(phases), -np.sin(phases)], 1)
    if np.linalg.matrix_rank(design) < 3:
        raise BadInput(f"phase shift: {len(phases)} steps do not tell phase, swing and light apart; give 3 or more")
    solved = np.tensordot(np.linalg.pinv(design), images, axes=1)
    return np.arctan2(solved[2], solved[1]), np.hypot(solved[1], solved[2])


def moving_phase(
    images: Float[np.ndarray, "n h w"], phases: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """`wrapped_phase` where steps go round more than once: what moves meanwhile leaves no waves (Zhang et al. 2024).

    Of each whole round, begun one step later than the last, the phase is found by itself. Even motion adds to it a
    wave of twice the phase, turned on by 4 pi / N from one to the next: binomial sums of neighbours cancel it, the
    more rounds the better. The phase is that of the middle of the steps.
    """
    steps = round_of(phases)
    if not 3 <= steps <= MOST_STEPS or len(phases) <= steps:
        return wrapped_phase(images, phases)
    first = len(phases) - steps + 1
    told = [wrapped_phase(images[k : k + steps], phases[k : k + steps]) for k in range(first)]
    weights = binomial_weights(steps, first)
    middle = told[first // 2][0]
    off = sum(w * wrap(phase - middle) for w, (phase, _) in zip(weights, told, strict=True))
    swing = sum(w * size for w, (_, size) in zip(weights, told, strict=True))
    return wrap(middle + off), np.asarray(swing)


def round_of(phases: Float[np.ndarray, " n"]) -> int:
    """After how many even steps phases come back to where they began; 0 where they are not even."""
    ahead = wrap(np.diff(phases))
    if not len(ahead) or abs(ahead[0]) < 1e-6 or np.abs(wrap(ahead - ahead[0])).max() > 1e-6:
        return 0
    steps = 2 * np.pi / abs(ahead[0])
    return round(steps) if abs(steps - round(steps)) < 1e-6 else 0


def binomial_weights(steps: int, count: int) -> Float[np.ndarray, " count"]:
    """Of `count` neighbouring phases: the power of the shortest sum in which what turns by 4 pi / steps is nothing."""
    factor = np.array([1.0, 1.0] if steps == 4 else [1.0, -2 * np.cos(4 * np.pi / steps), 1.0])
    weights = np.ones(1)
    while len(weights) + len(factor) - 1 <= count:
        weights = np.convolve(weights, factor / factor.sum())
    before = (count - len(weights)) // 2
    return np.pad(weights, (before, count - len(weights) - before))


def evened_phase(
    phase: Float[np.ndarray, "h w"], mask: Bool[np.ndarray, "h w"], window_px: float
) -> Float[np.ndarray, "h w"]:
    """A wrapped phase without the waves that gamma, saturation and steps of unequal light leave in each period.

    Over whole periods every phase comes equally often; where the phase is bent some come more often, by just as much.
    The integral of their density is the true phase.

    Args:
        window_px: standard deviation of the window over which phases are counted: a period or two. Over the whole
            picture they must not be: how far a phase is bent depends on how bright the skin is.
    """
    weight = np.maximum(ndimage.gaussian_filter(mask.astype(float), window_px), 1e-6)
    out = phase
    for n in range(1, WAVES + 1):
        turns = np.exp(-1j * n * phase)
        counted = [ndimage.gaussian_filter(np.where(mask, part, 0.0), window_px) for part in (turns.real, turns.imag)]
        density = (counted[0] + 1j * counted[1]) / weight
        out = out + 2 * np.real(density / turns / (1j * n))
    return wrap(out)


def decode_gray(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, axis: str = "x", smooth: bool = True
) -> Decoded:
    """Projector pixels of an axis from its Gray code and inverses; whole, or averaged over a small window.

    Raises:
        BadInput: a bit or its inverse is missing.
    """
    size = patterns.width if axis == "x" else patterns.height
    positive, negative = patterns.of("gray", axis=axis), patterns.of("gray_inverse", axis=axis)
    expected = list(range(bits_of(size)))
    for name, slots in (("gray", positive), ("gray_inverse", negative)):
        if [patterns.patterns[slot].bit for slot in slots] != expected:
            raise BadInput(f"patterns: axis {axis} needs {len(expected)} {name} bits in order, got {len(slots)}")
    code = np.zeros(images.shape[1:], np.int64)
    unclear = np.zeros(images.shape[1:], np.int64)
    parity = np.zeros(images.shape[1:], np.int64)
    for one, other in zip(positive, negative, strict=True):
        difference = images[one] - images[other]
        parity ^= (difference > 0).astype(np.int64)
        code = 2 * code + parity
        unclear += np.abs(difference) < CLEAR
    clear = (unclear <= 1) & (code < size)
    whole = np.where(clear, code, np.nan).astype(float)
    if not smooth:
        return Decoded(whole, np.where(clear, 1 / np.sqrt(12), np.nan))
    return Decoded(window_plane(whole), np.where(clear, 1 / np.sqrt(12) / WINDOW, np.nan))


def window_plane(codes: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    """Each known pixel's value of the plane fitted to the known ones within the window; jumps are left out.

    The window is symmetric, so where all of it is known the plane's value at the centre is the mean.
    """
    reach = WINDOW // 2
    padded = np.pad(codes, reach, constant_values=np.nan)
    total, weight = np.zeros_like(codes), np.zeros_like(codes)
    height, width = codes.shape
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            there = padded[reach + dy : reach + dy + height, reach + dx : reach + dx + width]
            opposite = padded[reach - dy : reach - dy + height, reach - dx : reach - dx + width]
            near = (np.abs(there - codes) < 2 * WINDOW) & (np.abs(opposite - codes) < 2 * WINDOW)
            total += np.where(near, there, 0.0)
            weight += near
    return np.where(weight > 0, total / np.maximum(weight, 1), np.nan)


def decode_phase(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, config: DecodeConfig = DecodeConfig()
) -> Decoded:
    """Columns from a phase shift, its period told by the Gray code of the same axis.

    Raises:
        BadInput: steps of several periods, no code to unwrap by, or one that has nothing to do with the phase.
    """
    slots = patterns.of("sinusoid", axis="x")
    periods = {patterns.patterns[slot].periods for slot in slots}
    if len(periods) != 1:
        raise BadInput(f"phase shift: expected steps of one period, got {len(periods)}")
    lit, _ = lit_pixels(images, patterns, slots, config)
    phase, swing = moving_phase(images[slots], np.array([patterns.patterns[slot].phase for slot in slots]))
    period = patterns.width / periods.pop()
    within = phase / (2 * np.pi) * period - 0.5
    coarse = decode_gray(images, patterns, "x", smooth=False).pixel
    columns = within + period * np.round((coarse - within) / period)
    sound = lit & (swing > config.noise) & (np.abs(columns - coarse) < period / 2)
    if sound.any() and np.median(np.abs(columns - coarse)[sound]) > APART * period:
        raise BadInput("phase shift and Gray code tell different columns: wrong order of the steps, or another list")
    sigma = config.noise * period / (2 * np.pi) * np.sqrt(2 / len(slots)) / np.maximum(swing, config.noise)
    return Decoded(np.where(sound, columns, np.nan), np.where(sound, sigma, np.nan))


def unwrap(phase: Float[np.ndarray, "h w"], mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    """A wrapped phase made continuous over each connected piece of the mask, along its most reliable edges.

    Edges are sorted by how much the phase bends across them, and the tree of the straightest ones is followed
    (Herraez et al. 2002's criterion on a minimum spanning tree). NaN outside the mask.
    """
    number = np.full(mask.shape, -1)
    number[mask] = np.arange(mask.sum())
    bend = bending(phase, mask)
    pieces = []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        both = mask[one] & mask[other]
        pieces.append((number[one][both], number[other][both], (bend[one] + bend[other])[both]))
    a, b, cost = (np.concatenate(part) for part in zip(*pieces, strict=True))
    graph = sp.csr_matrix((cost + 1e-6, (a, b)), shape=(mask.sum(),) * 2)
    tree = csgraph.minimum_spanning_tree(graph)
    count, labels = csgraph.connected_components(tree, directed=False)
    values = phase[mask]
    out = np.empty_like(values)
    roots = np.array([np.flatnonzero(labels == k)[0] for k in range(count)]) if count < 64 else _firsts(labels)
    for root in roots:
        _follow(tree, int(root), values, out)
    image = np.full(mask.shape, np.nan)
    image[mask] = out
    return image


def _firsts(labels: np.ndarray) -> np.ndarray:
    return np.unique(labels, return_index=True)[1]


def _follow(tree: sp.csr_matrix, root: int, values: np.ndarray, out: np.ndarray) -> None:
    """Add the wrapped steps from the root on; sums along the tree by doubling."""
    order, before = csgraph.breadth_first_order(tree, root, directed=False)
    above = before.copy()
    above[root] = root
    step = np.zeros_like(values)
    step[order] = wrap(values[order] - values[above[order]])
    while (above[order] != root).any():
        step[order] = step[order] + step[above[order]]
        above[order] = above[above[order]]
    out[order] = values[root] + step[order]


def wrap(angle: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    """Into -pi..pi."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def bending(phase: Float[np.ndarray, "h w"], mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    """Second differences of the phase, wrapped: large where noise or an edge makes a path unreliable."""
    total = np.zeros_like(phase)
    for axis in (0, 1):
        ahead = wrap(np.roll(phase, -1, axis) - phase)
        total += np.abs(ahead - np.roll(ahead, 1, axis))
    return np.where(ndimage.binary_erosion(mask), total, total + np.pi)
