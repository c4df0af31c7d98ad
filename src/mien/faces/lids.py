"""Fitting the lids' expressions to a person's eyes: a blink must close this opening, not the average one."""

import numpy as np
from jaxtyping import Float, Int

OVERLAP = 0.4
"""How far the closed upper lid comes over the lower one, mm: enough that rounding and blending leave no slit."""
SLACK = 0.7
"""Added to both travels before they are divided, mm: keeps the quotient at 1 in the corners, where both are 0."""

MOVES = 0.5
"""What comes down by so much, mm, or more, is scaled in full."""
LEAST_SCALE, MOST_SCALE = 0.2, 2.5
"""A blink's travel is made no shorter and no longer than these times."""
ROUNDS = 4
"""Where the lids meet changes with the travel: the quotient is taken anew so many times."""
FLOOR = 0.1
"""Added to a column's weight in the parabola, mm of fall: the corners, where nothing falls, still speak."""
FALLS = 0.5
"""Columns that fall this share of the longest fall, or more, must close."""


def fit_blink(
    vertices: Float[np.ndarray, "n 3"],
    blink: Float[np.ndarray, "n 3"],
    upper: Int[np.ndarray, " u"],
    lower: Int[np.ndarray, " l"],
    centre: Float[np.ndarray, " 3"],
) -> Float[np.ndarray, "n 3"]:
    """A blink's displacement (n, 3), mm, whose upper lid stops at the lower lid's edge of the face `vertices`.

    `upper` and `lower` are the lids' edges from one corner to the other by increasing x, `centre` the eyeball's.
    What comes down is scaled by the travel needed over the travel there: a parabola in x, raised until no column
    stays open. What moves keeps its distance from the eyeball, so that a shorter way does not lead through it.
    """
    down = np.clip(-blink[:, 1] / MOVES, 0, 1)
    share = 2 * (vertices[:, 0] - vertices[upper[0], 0]) / (vertices[upper[-1], 0] - vertices[upper[0], 0]) - 1
    basis = np.stack([np.ones_like(share), share, share**2], 1)[upper[1:-1]]
    scale = np.ones(len(vertices))
    for _ in range(ROUNDS):
        closed = vertices + blink * scale[:, None]
        fall = vertices[upper[1:-1], 1] - closed[upper[1:-1], 1]
        open_still = gaps(closed, upper, lower)
        longer = (fall + open_still + OVERLAP + SLACK) / (fall + SLACK)
        ratio = np.clip(scale[upper[1:-1]] * longer, LEAST_SCALE, MOST_SCALE)
        weight = np.maximum(fall, 0) + FLOOR
        a, b, c = np.linalg.lstsq(basis * weight[:, None], ratio * weight, rcond=None)[0]
        raised = np.max((ratio - basis @ (a, b, c)) * (fall > FALLS * fall.max()), initial=0)
        t = np.clip(share, -1, 1)
        scale = 1 + down * (np.clip(a + raised + b * t + c * t**2, LEAST_SCALE, MOST_SCALE) - 1)
    return _round(vertices, blink, scale, centre)


def opening(vertices: Float[np.ndarray, "n 3"], upper: Int[np.ndarray, " u"], lower: Int[np.ndarray, " l"]) -> float:
    """Mean height of the opening between the lids' edges, mm."""
    return float(gaps(vertices, upper, lower).mean())


def gaps(
    vertices: Float[np.ndarray, "n 3"], upper: Int[np.ndarray, " u"], lower: Int[np.ndarray, " l"]
) -> Float[np.ndarray, " g"]:
    """Height above the lower edge of every vertex of the upper edge but the corners', mm; below 0 they overlap."""
    return vertices[upper[1:-1], 1] - _curve(vertices[lower], vertices[upper[1:-1], 0])


def _curve(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The second coordinate of a polyline at `x`, held beyond its ends."""
    order = np.argsort(points[:, 0], kind="stable")
    return np.interp(x, points[order, 0], points[order, 1])


def _round(vertices: np.ndarray, blink: np.ndarray, scale: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """The scaled displacement, turned about the eyeball where it is neither 0 nor full."""
    start, end = vertices - centre, vertices + blink - centre
    radius, full = np.linalg.norm(start, axis=1), np.linalg.norm(end, axis=1)
    moved = start + scale[:, None] * blink
    wanted = radius + np.clip(scale, 0, 1) * (full - radius)
    there = np.maximum(np.linalg.norm(moved, axis=1), 1e-9)
    rounded = moved * (np.maximum(wanted, there) / there)[:, None]
    return np.where((scale != 1)[:, None], rounded - start, blink)
