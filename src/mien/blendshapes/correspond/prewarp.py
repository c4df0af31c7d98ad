"""The rough warp: a Delaunay triangulation of the landmarks, affine in every triangle (Casas et al. 2016, sec. 4.3)."""

import numpy as np
from jaxtyping import Float
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import QhullError

from ...errors import BadInput
from ...image_space.layout import grid_of

ANCHORS = 9
"""Points along each side of the map that stay where they are."""
APART = 0.05
"""Pixels: of points nearer to each other than this one is enough."""


def prewarp(
    neutral: Float[np.ndarray, "k 2"], source: Float[np.ndarray, "k 2"], shape: tuple[int, int]
) -> Float[np.ndarray, "h w 2"]:
    """Flow (dx, dy) from every pixel of the neutral's map to the source's, exact at the landmarks (x, y).

    Raises:
        BadInput: fewer than three landmarks.
    """
    if len(neutral) < 3:
        raise BadInput(f"warp: {len(neutral)} landmarks are known in both scans; three at least are needed")
    rim = _rim(shape)
    places = np.concatenate([neutral, rim])
    moves = np.concatenate([source - neutral, np.zeros_like(rim)])
    _, first = np.unique(np.round(places / APART), axis=0, return_index=True)
    try:
        warp = LinearNDInterpolator(places[first], moves[first], fill_value=0.0)
    except QhullError as error:
        raise BadInput("warp: the landmarks lie on one line") from error
    return warp(grid_of(shape).reshape(-1, 2)).reshape(*shape, 2)


def _rim(shape: tuple[int, int]) -> Float[np.ndarray, "a 2"]:
    height, width = shape
    x, y = np.linspace(-1, width, ANCHORS), np.linspace(-1, height, ANCHORS)
    sides = [np.stack([x, np.full(ANCHORS, end)], 1) for end in (-1.0, height)]
    sides += [np.stack([np.full(ANCHORS, end), y], 1) for end in (-1.0, width)]
    return np.unique(np.concatenate(sides), axis=0)
