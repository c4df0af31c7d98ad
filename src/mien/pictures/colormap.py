"""Colour maps for values, even to the eye, and the scale that goes beside them.

Made of control points in OKLCH (Ottosson 2020: lightness, chroma, hue in degrees): lightness runs in a straight line,
so equal steps of a value look equal; colours outside sRGB lose chroma until they are inside.
"""

from functools import cache

import numpy as np
from jaxtyping import Float
from scipy.interpolate import PchipInterpolator

from ..errors import BadInput
from .color import to_linear, to_srgb

MAPS = {
    "heat": [(0.43, 0.115, 266), (0.56, 0.10, 230), (0.69, 0.115, 175), (0.82, 0.15, 130), (0.95, 0.16, 105)],
    "diverging": [(0.40, 0.13, 260), (0.675, 0.105, 246), (0.95, 0.0, 150), (0.675, 0.13, 45), (0.40, 0.14, 25)],
}
"""`heat` for what is never negative: blue to yellow, no end so dark that the face is lost. `diverging` for signed
values: blue, white, red."""

NOTHING = (0.55, 0.55, 0.55)
"""Colour of NaN, sRGB."""


LEVELS = 1024


@cache
def table(name: str, linear: bool = False) -> Float[np.ndarray, "levels 3"]:
    """The `LEVELS` colours of a map and, last, that of NaN; sRGB 0..1, or linear light.

    Raises:
        BadInput: no such map.
    """
    if name not in MAPS:
        raise BadInput(f"colour map {name!r}: there is none of that name; choose from {', '.join(MAPS)}")
    lightness, chroma, hue = np.array(MAPS[name], dtype=float).T
    tint = chroma * np.exp(1j * np.radians(hue))
    knots, t = np.linspace(0, 1, len(lightness)), np.linspace(0, 1, LEVELS)
    bent = (PchipInterpolator(knots, x)(t) for x in (tint.real, tint.imag))
    lab = np.stack([np.interp(t, knots, lightness), *bent], 1)
    colors = np.vstack([_into_gamut(lab), to_linear(np.array(NOTHING))])
    return colors if linear else to_srgb(colors)


def colors_of(
    values: Float[np.ndarray, "*n"], limits: tuple[float, float], name: str = "heat", linear: bool = False
) -> Float[np.ndarray, "*n 3"]:
    """Colours of values, sRGB 0..1 or linear light; beyond the limits the end colours, grey for NaN.

    Raises:
        BadInput: limits that do not increase, or no such map.
    """
    low, high = limits
    if not high > low:
        raise BadInput(f"colour limits {low:g}..{high:g}: the second must be the greater")
    share = np.clip((np.nan_to_num(values, nan=low, posinf=high, neginf=low) - low) / (high - low), 0, 1)
    level = np.where(np.isnan(values), LEVELS, np.rint(share * (LEVELS - 1))).astype(np.int64)
    return table(name, linear)[level]


def own_limits(values: Float[np.ndarray, "*n"]) -> tuple[float, float]:
    """The least and the greatest finite value; one more where they are the same, 0..1 where there is none."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return (low, high) if high > low else (low, low + 1)


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
