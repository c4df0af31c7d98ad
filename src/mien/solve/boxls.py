"""Least squares with bounds on every variable, for many frames at once, on Gram matrices."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from .._kernels.boxls import boxls

TOLERANCE = 1e-10
"""Breach of the optimality conditions that is let pass, relative to the largest slope of the cost."""


@dataclass(frozen=True)
class BoxResult:
    """What `box_least_squares` and `smooth_box_least_squares` found, one row a frame."""

    values: Float[np.ndarray, "frames k"]
    converged: Bool[np.ndarray, " frames"]
    """Whether the breach is within the tolerance."""
    iterations: Int[np.ndarray, " frames"]
    """Variables that entered or left their bounds; in the smooth solve, Newton steps (the same for all frames)."""
    breach: Float[np.ndarray, " frames"]
    """Largest breach of the optimality conditions (slope that a free variable still has, or that points off a bound
    into the box), relative to the largest slope of the cost."""


def box_least_squares(
    gram: Float[np.ndarray, "k k"] | Float[np.ndarray, "frames k k"],
    linear: Float[np.ndarray, "frames k"],
    lower: Float[np.ndarray, " k"] | float = 0.0,
    upper: Float[np.ndarray, " k"] | float = 1.0,
    l1: Float[np.ndarray, " k"] | float = 0.0,
    warm: Float[np.ndarray, "frames k"] | None = None,
) -> BoxResult:
    """Minimise 1/2 w'Gw - b'w + l1'|w| with lower <= w <= upper, for every frame by itself.

    Exact: a primal active set (Lawson and Hanson's, with bounds on both sides, as Stark and Parker's BVLS) on a
    tableau of G in which one variable is swept in or out a step. Dependent columns are allowed; the least value is then
    reached at one of several places. Frames are taken in fixed chunks, each frame starting where the one before
    ended, the chunks in parallel.

    Args:
        gram: A'A, positive semidefinite; one for all frames or one a frame.
        linear: A'x, one row a frame.
        lower, upper: bounds, a number or one a variable; infinite where there is none.
        l1: weight of the absolute values; needs lower >= 0 where it is not 0.
        warm: where to start.

    Raises:
        ValueError: sizes that do not agree, empty boxes, NaN, or `l1` over a box that goes below 0.
    """
    k = linear.shape[1]
    low, high, sparse = box(k, lower, upper, l1)
    grams = stacked(gram, linear)
    start = np.zeros((0, k)) if warm is None else _agreeing(warm, linear)
    values, breach, pivots = boxls(grams, np.ascontiguousarray(linear - sparse), low, high, start, TOLERANCE)
    return BoxResult(values, breach <= TOLERANCE, pivots, breach)


def box(k, lower, upper, l1):
    """Bounds and l1 as checked float64 arrays (k,)."""
    low, high, sparse = (np.array(np.broadcast_to(a, k), dtype=np.float64) for a in (lower, upper, l1))
    if not (low <= high).all():
        i = int(np.argmin(low <= high))
        raise ValueError(f"bounds: expected lower <= upper, got {low[i]} and {high[i]} for variable {i}")
    if ((sparse > 0) & (low < 0)).any():
        raise ValueError("l1: expected lower bounds >= 0 where l1 is not 0; |w| bends at 0")
    if (sparse < 0).any():
        raise ValueError(f"l1: expected >= 0, got {sparse.min()}")
    return low, high, sparse


def stacked(gram, linear):
    """`gram` as a checked float64 array (1 or frames, k, k)."""
    frames, k = linear.shape
    grams = np.ascontiguousarray(gram if gram.ndim == 3 else gram[None], dtype=np.float64)
    if grams.shape[1:] != (k, k) or len(grams) not in (1, frames):
        raise ValueError(f"gram: expected ({k}, {k}) or ({frames}, {k}, {k}) to go with linear, got {gram.shape}")
    if not (np.isfinite(grams).all() and np.isfinite(linear).all()):
        raise ValueError("gram, linear: expected finite numbers, got NaN or infinity; leave unseen data out")
    return grams


def _agreeing(warm, linear):
    if warm.shape != linear.shape or not np.isfinite(warm).all():
        raise ValueError(f"warm: expected finite numbers of shape {linear.shape}, got {warm.shape}")
    return np.ascontiguousarray(warm, dtype=np.float64)
