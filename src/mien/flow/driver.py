"""Coarse to fine: each level starts from the flow of the coarser one (Papenberg et al. 2006, sec. 5)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .warp import Level, enlarge


@dataclass(frozen=True)
class Solved:
    """What an inner solver found at one level."""

    flow: Float[np.ndarray, "h w 2"]
    """Pixels of the level, (dx, dy)."""
    converged: bool
    """Whether the last step was below the tolerance."""
    iterations: int
    """Warps done."""
    energy: Float[np.ndarray, "warps inner"]
    """Energy at the start of every inner iteration, a row a warp; a row's first entry is the full, nonlinear energy."""
    residual: Float[np.ndarray, "h w"]
    """Root mean square difference of the channels at the flow found; NaN where there is no data."""


def coarse_to_fine(
    levels: Sequence[Level], solve: Callable[[Level, Float[np.ndarray, "h w 2"]], Solved]
) -> list[Solved]:
    """Solve each level, the coarsest (last) first, starting from 0 and then from the enlarged flow of the one before.

    `solve` gets a level and a flow to start from, in pixels of that level. The results are in the order solved.
    """
    results: list[Solved] = []
    for level in reversed(levels):
        h, w = level.source_weight.shape
        start = np.zeros((h, w, 2), np.float32)
        if results:
            coarse = results[-1].flow
            height, width, _ = coarse.shape
            ratio = np.array([w / width, h / height], np.float32)
            start = enlarge(coarse, (h, w)) * ratio
        found = solve(level, start)
        results.append(found)
    return results
