"""Scales: round ticks for every axis, and the legend that stands beside a heat map."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image, ImageDraw, ImageFont

from .colormap import colors_of

PAPER, INK = (28, 29, 31), (232, 232, 234)
"""Colour between pictures, and of words on it."""


@lru_cache(maxsize=16)
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own scalable font, so that pictures look the same on every machine; `size` in pixels."""
    return ImageFont.load_default(size)


def nice_ticks(low: float, high: float, about: int = 5) -> Float[np.ndarray, " ticks"]:
    """Round numbers (1, 2, 2.5 or 5 times a power of ten apart) within low..high, about `about` of them."""
    if not high > low:
        return np.array([low])
    rough = (high - low) / about
    power = 10.0 ** np.floor(np.log10(rough))
    step = min((s for s in (1, 2, 2.5, 5, 10)), key=lambda s: abs(np.log(s * power / rough))) * power
    first = np.ceil(low / step - 1e-9)
    return np.arange(first, np.floor(high / step + 1e-9) + 1) * step + 0.0


def number(value: float) -> str:
    """A tick's number: short, no trailing zeros, no minus zero."""
    return f"{value + 0.0:.6g}"


def scale_bar(
    width: int,
    height: int,
    limits: tuple[float, float],
    unit: str = "mm",
    colormap: str = "heat",
    upright: bool | None = None,
) -> UInt8[np.ndarray, "h w 3"]:
    """The legend of a heat map: a strip of its colours with numbers.

    Args:
        width, height: pixels of the whole legend.
        limits: values at the two ends.
        upright: the greatest value on top rather than on the right; by default where the legend is taller than wide.
    """
    page = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(page)
    upright = height > width if upright is None else upright
    along, across = (height, width) if upright else (width, height)
    size = int(np.clip(across * (0.17 if upright else 0.34), 9, 22))
    pad = min(round(size * 1.4), along // 4)
    room = 0 if upright else round(font(size).getlength(f" {unit}"))
    length = max(along - 2 * pad - room, 2)
    strip = (colors_of(np.linspace(*limits, length), limits, colormap) * 255 + 0.5).astype(np.uint8)
    thick = max(4, round(across * 0.3))
    pixels = np.repeat(strip[::-1, None], thick, 1) if upright else np.repeat(strip[None], thick, 0)
    corner = (size // 2, pad) if upright else (pad, size // 2)
    page.paste(Image.fromarray(pixels), corner)
    ticks = nice_ticks(*limits, about=int(np.clip(length // (4 * size if upright else 8 * size), 2, 8)))
    for tick in ticks:
        at = (tick - limits[0]) / (limits[1] - limits[0]) * (length - 1)
        at = length - 1 - at if upright else at
        _tick(draw, number(tick), unit if tick == ticks[-1] else "", upright, corner, thick, at, size)
    return np.asarray(page)


def _tick(draw, text: str, unit: str, upright: bool, corner, thick: int, at: float, size: int) -> None:
    """One tick `at` pixels along the strip, its number, and the unit after the last number."""
    x, y = corner
    if upright:
        draw.line((x + thick, y + at, x + thick + size // 3, y + at), fill=INK)
        draw.text((x + thick + size // 2, y + at), f"{text} {unit}", font=font(size), fill=INK, anchor="lm")
    else:
        draw.line((x + at, y + thick, x + at, y + thick + size // 3), fill=INK)
        draw.text((x + at, y + thick + size // 2), text, font=font(size), fill=INK, anchor="ma")
        half = font(size).getlength(text) / 2
        draw.text((x + at + half, y + thick + size // 2), f" {unit}", font=font(size), fill=INK, anchor="la")
