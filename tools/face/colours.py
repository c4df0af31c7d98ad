"""Plausible colours for the vertices, so that a preview looks like a person."""

import numpy as np

from .contours import Contours
from .layout import RINGS, Layout
from .regions import on_face, step

SKIN, LIPS, BLUSH, BROW = (0.82, 0.64, 0.55), (0.70, 0.42, 0.39), (0.80, 0.53, 0.46), (0.36, 0.26, 0.20)
WHITE, IRIS, RIM, PUPIL = (0.90, 0.88, 0.86), (0.38, 0.30, 0.20), (0.20, 0.16, 0.12), (0.03, 0.03, 0.03)
TEETH, TONGUE, MOUTH = (0.90, 0.87, 0.80), (0.72, 0.40, 0.40), (0.42, 0.18, 0.17)
BROW_LINE = np.array([[13, 17], [24, 21], [36, 22.5], [46, 20], [54, 15]])
"""x, y of the left brow's middle, mm."""


def colours(vertices: np.ndarray, plan: Layout, lines: Contours, uv_masks: dict[str, np.ndarray]) -> np.ndarray:
    """Vertex colours (n, 3), sRGB in 0..1."""
    uv = {name: on_face(mask, plan) for name, mask in uv_masks.items()}
    x, y, z = np.abs(vertices[:, 0]), *vertices.T[1:]
    skin = np.tile(SKIN, (len(vertices), 1))
    cheeks = np.exp(-(((x - 42) / 16) ** 2) - ((y + 32) / 15) ** 2) * step(z, 30, 60)
    nose = np.exp(-((x / 13) ** 2) - ((y + 38) / 12) ** 2) * step(z, 90, 110)
    ears = uv["ears"] * 0.5
    for share, colour in (
        (np.clip(0.6 * cheeks + 0.5 * nose + ears, 0, 1), BLUSH),
        (0.25 * uv["eyelids"], BLUSH),
        (0.7 * _brow(x, y) * step(z, 40, 55), BROW),
        (0.85 * uv["lips"], LIPS),
        (step(uv["inside-mouth"], 0.2, 0.8), MOUTH),
    ):
        skin = _mix(skin, share, colour)
    skin[lines.lashes] = 0.45 * skin[lines.lashes] + 0.55 * np.array(BROW)
    for part, colour in ((3, TEETH), (4, TEETH), (5, TONGUE)):
        skin[plan.part == part] = colour
    for part in (1, 2):
        skin[plan.part == part] = _eye(plan.ball)
    return skin


def _mix(base: np.ndarray, share: np.ndarray, colour) -> np.ndarray:
    return base + np.clip(share, 0, 1)[:, None] * (np.asarray(colour) - base)


def _brow(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """1 on the brow's line, fading over a few millimetres; thinner outwards."""
    line = np.interp(x, *BROW_LINE.T)
    inside = step(x, 6, 17) * step(x, 61, 48)
    return inside * np.exp(-(((y - line) / np.interp(x, [13, 55], [5.5, 3.6])) ** 2))


def _eye(ball: np.ndarray) -> np.ndarray:
    """An eyeball about +Z: pupil, iris with a darker rim, white."""
    angle = np.arccos(np.clip(ball[:, 2], -1, 1))
    ring = RINGS + 1e-6
    colour = np.tile(WHITE, (len(ball), 1))
    for upto, value in ((ring[4], RIM), (ring[3], IRIS), (ring[1], PUPIL)):
        colour[angle <= upto] = value
    return colour
