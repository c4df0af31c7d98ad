"""Whether a capture's pictures are linear and in the order of their list, told by themselves."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from .decode_sinusoids import DecodeConfig, Ratios, measured_ratios, polish, search
from .normals import LEAST_LIGHT
from .patterns import PatternSet

JUDGED = 1500
"""Pixels on which pictures are judged."""
BRIGHT = 0.5
"""Pixels count whose full-on value is above this share of the picture's bright ones: the face, not the wall behind."""
SUSPECT = 0.06
"""Root mean square of ratios off their patterns, above which another reading is tried; a face that moves by 7 mm within
a capture comes to 0.05, gamma of 1.4 to 0.07, two swapped slots to 0.06 and more."""
BETTER = 0.5
"""Another reading is believed if it leaves less than this share of that."""
HOPELESS = 0.3
"""Above this ratios lie outside 0..1: what is listed as full-on is not."""
ALIKE = 0.9
"""Mean cosine between the lamps' normals and the surface's from which on an order of conditions is the right one."""
CLEARER = 0.05
"""By which it must exceed that of the listed order."""
EXPONENTS = (0.45, 0.6, 0.75, 1.35, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6)
"""Of stored values, tried beside 1."""
ROOM = (0.1, 0.2, 0.3)
"""Of what full-on shows, tried as light of the room, which lifts the dark values as gamma does."""
BROKEN = 0.3
"""Share of full-on by which patterns that make it up together miss it where they do not belong together: half of the
pixels are off by one half then."""
FEWER = 0.6
"""A finer bit of a Gray code changes about twice as often along a row as the one before; never less often than this."""


def check_signal(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, name: str, gamma: float, config: DecodeConfig
) -> None:
    """Refuse the pictures of camera `name` if they are not linear or not in the order of their list.

    Args:
        gamma: with which they were made linear.

    Raises:
        BadInput: the line says which of both, and what to do.
    """
    periods = {patterns.patterns[slot].periods for slot in patterns.of("sinusoid", axis="x")}
    if len(periods) > 1:
        return check_sinusoids(images, patterns, name, gamma, config)
    if patterns.of("full") and patterns.of("black"):
        check_sums(images, patterns, name, gamma)
        check_bits(images, patterns, name)


def check_sinusoids(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, name: str, gamma: float, config: DecodeConfig
) -> None:
    """Ratios of folded sinusoids must agree on one column; if they do for another exponent or order, that is right.

    Raises:
        BadInput: they do.
    """
    pixels = bright_pixels(images, patterns)
    off = sinusoids_off(pixels, patterns, config)
    if off < SUSPECT:
        return
    exponent, left = min(((g, sinusoids_off(pixels**g, patterns, config)) for g in EXPONENTS), key=lambda told: told[1])
    if left < BETTER * off:
        room = min(sinusoids_off(pixels - share * pixels[[patterns.one("full")]], patterns, config) for share in ROOM)
        if room < left:
            return
        raise BadInput(not_linear(name, gamma, exponent))
    order, left = min(
        ((order, sinusoids_off(pixels[order], patterns, config)) for order in orders(patterns)),
        key=lambda told: told[1],
    )
    if left < BETTER * off:
        moved = [slot for slot in range(len(order)) if order[slot] != slot]
        raise BadInput(
            f"{name}: the slots are in another order than in patterns.json: what is listed as slot {moved[0]} "
            f"({patterns.patterns[moved[0]].kind}) is shown in slot {order[moved[0]]}; "
            f"{len(moved)} of {len(order)} slots are elsewhere"
        )
    if off > HOPELESS:
        raise BadInput(f"{name}: the pictures do not follow patterns.json: another list, or wrong order of the slots")


def bright_pixels(images: Float[np.ndarray, "slots h w"], patterns: PatternSet) -> Float[np.ndarray, "slots 1 p"]:
    """Some of the pixels that show the face, whichever of the slots is full-on: the brightest on average."""
    mean = images.mean(axis=0)
    bright = np.flatnonzero(mean > BRIGHT * np.quantile(mean, 0.95))
    chosen = bright[:: max(len(bright) // JUDGED, 1)]
    return images.reshape(len(patterns), 1, -1)[..., chosen]


def sinusoids_off(pixels: Float[np.ndarray, "slots 1 p"], patterns: PatternSet, config: DecodeConfig) -> float:
    """Median over pixels of the root mean square by which ratios miss their patterns at the likeliest column."""
    try:
        ratios = measured_ratios(pixels, patterns, replace(config, border_px=0))
    except BadInput:
        return np.inf
    start = search(ratios, config)
    return off_patterns(polish(start, np.zeros_like(start), ratios).columns, ratios)


def off_patterns(columns: Float[np.ndarray, " p"], ratios: Ratios) -> float:
    """How far ratios are from what their patterns are at these columns."""
    expected = (1 + ratios.contrast * np.cos(columns[:, None] * ratios.rates + ratios.shifts)) / 2
    off = ratios.values - expected
    return float(np.median(np.sqrt((off**2).mean(axis=1))))


def orders(patterns: PatternSet) -> Iterator[np.ndarray]:
    """Mistakes that happen: a start some slots early or late, the list backwards, two slots swapped."""
    count = len(patterns)
    for late in range(1, count):
        yield np.roll(np.arange(count), late)
    yield np.arange(count)[::-1]
    for one, other in combinations(range(count), 2):
        if patterns.of("sinusoid", "full")[-1] >= one:
            order = np.arange(count)
            order[[one, other]] = other, one
            yield order


def check_sums(images: Float[np.ndarray, "slots h w"], patterns: PatternSet, name: str, gamma: float) -> None:
    """Light adds up: a Gray code and its inverse make full-on and black, the steps of a phase shift their mean.

    Raises:
        BadInput: they do so for another exponent only, or not at all.
    """
    groups = whole_groups(patterns)
    if not groups:
        return
    pixels = bright_pixels(images, patterns)
    worst = max(groups, key=lambda group: sum_off(pixels, patterns, group))
    off = sum_off(pixels, patterns, worst)
    left, exponent = min((max(sum_off(pixels**g, patterns, group) for group in groups), g) for g in EXPONENTS)
    if off > SUSPECT and left < min(BETTER * off, SUSPECT):
        raise BadInput(not_linear(name, gamma, exponent))
    if off > BROKEN:
        raise BadInput(
            f"{name}: slots {', '.join(str(slot) for slot in worst)} ({patterns.patterns[worst[0]].kind}) do not "
            "make up the full-on pattern together: wrong order of the slots, or another list than patterns.json"
        )


def whole_groups(patterns: PatternSet) -> list[list[int]]:
    """Slots that together are even light."""
    groups = []
    for axis in ("x", "y"):
        pairs = zip(patterns.of("gray", axis=axis), patterns.of("gray_inverse", axis=axis), strict=False)
        groups += [list(pair) for pair in pairs]
        steps = patterns.of("sinusoid", axis=axis)
        turns = np.exp(1j * np.array([patterns.patterns[slot].phase for slot in steps]))
        even = len(steps) > 2 and abs(turns.mean()) < 1e-6
        groups += [steps] if even and len({patterns.patterns[slot].periods for slot in steps}) == 1 else []
    return groups


def sum_off(pixels: Float[np.ndarray, "slots 1 p"], patterns: PatternSet, group: list[int]) -> float:
    """Root mean square by which the group's mean misses that of full-on and black, share of their difference."""
    full, black = pixels[patterns.one("full")], pixels[patterns.one("black")]
    scale = float(np.median(full - black))
    if scale <= 0:
        return np.inf
    off = pixels[group].mean(axis=0) - (full + black) / 2
    return float(np.sqrt((off**2).mean()) / scale)


def check_bits(images: Float[np.ndarray, "slots h w"], patterns: PatternSet, name: str) -> None:
    """Bits of a Gray code, listed coarse to fine, change ever more often across the picture.

    Raises:
        BadInput: a bit that changes less often than a coarser one.
    """
    full, black = images[patterns.one("full")], images[patterns.one("black")]
    bright = full - black > BRIGHT * np.quantile(full - black, 0.95)
    for axis in ("x", "y"):
        pairs = list(zip(patterns.of("gray", axis=axis), patterns.of("gray_inverse", axis=axis), strict=False))
        counts = [changes(images[one] - images[other], bright, full - black) for one, other in pairs]
        for (slot, _), coarse, fine in zip(pairs[1:], counts, counts[1:], strict=False):
            if fine < FEWER * coarse - bright.shape[0]:
                raise BadInput(
                    f"{name}: slot {slot}, bit {patterns.patterns[slot].bit} of axis {axis}, changes less often "
                    "than the coarser bit before it: wrong order of the slots"
                )


def changes(difference: Float[np.ndarray, "h w"], bright: np.ndarray, swing: np.ndarray) -> int:
    """Clear changes of sign between neighbouring bright pixels, along rows and columns."""
    sign = np.where(bright & (np.abs(difference) > 0.1 * swing), np.sign(difference), 0)
    return int((sign[:, 1:] * sign[:, :-1] < 0).sum() + (sign[1:] * sign[:-1] < 0).sum())


def check_gradients(
    images: Float[np.ndarray, "slots h w"],
    patterns: PatternSet,
    R_view_lamps: Float[np.ndarray, "3 3"],
    geometry: Float[np.ndarray, "h w 3"],
) -> None:
    """The lamps' conditions in their listed order must give the normals that the triangulated surface has.

    Raises:
        BadInput: they do in another order.
    """
    listed = [patterns.one("constant"), *(patterns.of("gradient", axis=axis)[0] for axis in "xyz")]
    known = np.isfinite(geometry).all(-1) & (images[listed].min(axis=0) > LEAST_LIGHT)
    some = np.flatnonzero(known)[:: max(int(known.sum()) // (4 * JUDGED), 1)]
    pixels, shape = images.reshape(len(images), -1)[:, some], geometry.reshape(-1, 3)[some]
    told = {order: alike(pixels[list(order)], R_view_lamps, shape) for order in permutations(listed)}
    best = max(told, key=lambda order: told[order])
    if told[best] > ALIKE and told[best] > told[tuple(listed)] + CLEARER:
        right = ", ".join(f"slot {slot} as {patterns.patterns[slot].kind}" for slot in listed)
        shown = ", ".join(str(slot) for slot in best)
        raise BadInput(
            f"the lamps' conditions are in another order than in patterns.json: the surface fits slots {shown} "
            f"where {right} are listed"
        )


def alike(
    conditions: Float[np.ndarray, "4 p"], R_view_lamps: Float[np.ndarray, "3 3"], shape: Float[np.ndarray, "p 3"]
) -> float:
    """Mean cosine between normals from constant light and three gradients, and the surface's."""
    vectors = (2 * conditions[1:] / conditions[0] - 1).T @ R_view_lamps.T
    length = np.maximum(np.linalg.norm(vectors, axis=1), 1e-6)
    return float(((vectors * shape).sum(axis=1) / length).mean()) if len(shape) else 0.0


def not_linear(name: str, gamma: float, exponent: float) -> str:
    """The line about pictures that another exponent explains."""
    told = gamma * exponent
    return (
        f"{name}: the camera looks gamma-encoded: its pictures fit the patterns with gamma {told:.1f}, "
        f'not {gamma:.1f}; record linear pictures, or set "gamma": {told:.1f} in calibration.json'
    )
