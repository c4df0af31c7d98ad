"""What was seen of two numbers at many places, as a convex polygon each, and the nearest point within."""

from collections.abc import Iterable

import numpy as np
from jaxtyping import Bool, Float

PIECE = 64
"""Frames that are held against the polygons at a time, so that memory does not grow with the take."""


def hulls(points: Float[np.ndarray, "n k 2"]) -> Float[np.ndarray, "k e 2"]:
    """The convex hull of the n points at each of k places, counter-clockwise; shorter ones repeat their last corner."""
    corners = [_hull(points[:, place]) for place in range(points.shape[1])]
    most = max(map(len, corners))
    return np.stack([np.concatenate([c, np.repeat(c[-1:], most - len(c), axis=0)]) for c in corners])


def nearest_in_hulls(
    points: Float[np.ndarray, "t k 2"], corners: Float[np.ndarray, "k e 2"]
) -> Float[np.ndarray, "t k 2"]:
    """Each point, or the nearest one of its place's polygon where it lies outside."""
    pieces = [_nearest(points[first : first + PIECE], corners) for first in range(0, len(points), PIECE)]
    return np.concatenate(pieces) if pieces else points


def _nearest(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    edges = np.roll(corners, -1, axis=1) - corners
    away = points[:, :, None] - corners
    length2 = (edges**2).sum(axis=-1)
    share = np.clip((away * edges).sum(axis=-1) / np.maximum(length2, 1e-30), 0, 1)
    feet = corners + share[..., None] * edges
    best = ((points[:, :, None] - feet) ** 2).sum(axis=-1).argmin(axis=-1)
    foot = np.take_along_axis(feet, best[..., None, None], axis=2)[:, :, 0]
    return np.where(_inside(away, edges, length2)[..., None], points, foot)


def _inside(away: np.ndarray, edges: np.ndarray, length2: np.ndarray) -> Bool[np.ndarray, "t k"]:
    """Left of every edge; a polygon without area has no inside."""
    left = edges[..., 0] * away[..., 1] - edges[..., 1] * away[..., 0] > 0
    real = length2 > 0
    return np.all(left | ~real, axis=-1) & np.any(real, axis=-1)


def _hull(points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "e 2"]:
    """Andrew's monotone chain (1979)."""
    ordered = np.unique(points, axis=0)
    if len(ordered) < 3:
        return ordered
    return np.array([*_chain(ordered.tolist())[:-1], *_chain(ordered[::-1].tolist())[:-1]])


def _chain(ordered: Iterable[list[float]]) -> list[list[float]]:
    out: list[list[float]] = []
    for point in ordered:
        while len(out) > 1 and _turn(out[-2], out[-1], point) <= 0:
            out.pop()
        out.append(point)
    return out


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
