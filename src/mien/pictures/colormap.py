"""Colour maps for values, even to the eye, and the scale that goes beside them.

Made of control points in OKLCH (Ottosson 2020: lightness, chroma, hue in degrees): lightness runs in a straight line,
so equal steps of a value look equal; colours outside sRGB lose chroma until they are inside.
"""

from functools import cache

import numpy as np
from jaxtyping import Float
from scipy.interpolate import PchipInterpolator

from ..errors import BadInput
from .color import to_srgb

MAPS = {
    "heat": [(0.27, 0.075, 300), (0.44, 0.105, 268), (0.61, 0.10, 215), (0.78, 0.145, 155), (0.95, 0.16, 108)],
    "diverging": [(0.40, 0.13, 260), (0.675, 0.105, 246), (0.95, 0.0, 150), (0.675, 0.13, 45), (0.40, 0.14, 25)],
}
"""`heat` for what is never negative: dark blue to yellow. `diverging` for signed values: blue, white, red."""

NOTHING = (0.55, 0.55, 0.55)
"""Colour of NaN, sRGB."""


@cache
def table(name: str) -> Float[np.ndarray, "levels 3"]:
    """1024 colours of a map, sRGB 0..1.

    Raises:
        BadInput: no such map.
    """
    if name not in MAPS:
        raise BadInput(f"colour map {name!r}: there is none of that name; choose from {', '.join(MAPS)}")
    lightness, chroma, hue = np.array(MAPS[name], dtype=float).T
    tint = chroma * np.exp(1j * np.radians(hue))
    knots, t = np.linspace(0, 1, len(lightness)), np.linspace(0, 1, 1024)
    lab = np.stack([PchipInterpolator(knots, x)(t) for x in (lightness, tint.real, tint.imag)], 1)
    return to_srgb(_into_gamut(lab))


def colors_of(
    values: Float[np.ndarray, "*n"], limits: tuple[float, float], name: str = "heat"
) -> Float[np.ndarray, "*n 3"]:
    """Colours of values, sRGB 0..1; beyond the limits the end colours, grey for NaN.

    Raises:
        BadInput: limits that do not increase, or no such map.
    """
    low, high = limits
    if not high > low:
        raise BadInput(f"colour limits {low:g}..{high:g}: the second must be the greater")
    colors = table(name)
    place = np.clip((np.nan_to_num(values, nan=low) - low) / (high - low), 0, 1) * (len(colors) - 1)
    below = np.minimum(place.astype(int), len(colors) - 2)
    share = (place - below)[..., None]
    mixed = (1 - share) * colors[below] + share * colors[below + 1]
    return np.where(np.isnan(values)[..., None], NOTHING, mixed)


def _into_gamut(lab: np.ndarray) -> np.ndarray:
    """OKLab (n, 3) -> linear sRGB, chroma cut down by bisection where needed."""
    low, high = np.zeros(len(lab)), np.ones(len(lab))
    inside = _linear_of_oklab(lab, high)
    if ((inside < 0) | (inside > 1)).any():
        for _ in range(24):
            middle = (low + high) / 2
            linear = _linear_of_oklab(lab, middle)
            fits = ((linear >= 0) & (linear <= 1)).all(1)
            low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return np.clip(_linear_of_oklab(lab, high), 0, 1)


def _linear_of_oklab(lab: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Linear sRGB of OKLab colours with `share` of their chroma."""
    L, a, b = lab[:, 0], lab[:, 1] * share, lab[:, 2] * share
    l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3
    m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3
    s = (L - 0.0894841775 * a - 1.2914855480 * b) ** 3
    return np.stack(
        [
            4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
        ],
        1,
    )
