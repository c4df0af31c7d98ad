"""Least squares on a grid of values and of steps between neighbours: conjugate gradients behind multigrid."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .._kernels import multigrid as kernel
from ..errors import BadInput

SMALLEST = 4
"""Rows or columns of the coarsest grid."""
COARSEST_ROUNDS = 8
"""Of relaxation there, which then is as good as solved."""


@dataclass(frozen=True)
class GridSolution:
    """A least-squares solution and how it was found."""

    values: Float[np.ndarray, "h w"]
    iterations: int
    converged: bool


@dataclass(frozen=True)
class GridLevel:
    """The equation on one of the grids, and room to solve it in."""

    weight: Float[np.ndarray, "h w"]
    across: Float[np.ndarray, "h w-1"]
    down: Float[np.ndarray, "h-1 w"]
    inverse: Float[np.ndarray, "h w"]
    """1 / diagonal, 0 where nothing is asked for."""
    values: Float[np.ndarray, "h w"]
    right: Float[np.ndarray, "h w"]


def solve_grid(
    target: Float[np.ndarray, "h w"],
    weight: Float[np.ndarray, "h w"],
    slopes: tuple[Float[np.ndarray, "h w-1"], Float[np.ndarray, "h-1 w"]],
    slope_weights: tuple[Float[np.ndarray, "h w-1"], Float[np.ndarray, "h-1 w"]],
    tolerance: float = 3e-6,
    limit: int = 80,
) -> GridSolution:
    """min_f sum w (f - target)^2 + sum over edges s (f_next - f - slope)^2; 0 where no weight and no edge is.

    One V-cycle is the preconditioner: it follows weights that differ a thousandfold and edges that are cut, where a
    cosine transform of even weights took four times as many iterations.

    Raises:
        BadInput: weights that leave nothing determined.
    """
    if not (weight > 0).any() or not any((s > 0).any() for s in slope_weights):
        raise BadInput("integration: no pixel has any weight")
    levels = grid_levels(weight, *slope_weights)
    right = weight * target + sources(slope_weights[0] * slopes[0], slope_weights[1] * slopes[1])
    usual = float(np.average(target, weights=weight))
    start = np.where(weight > 0, target, np.where(levels[0].inverse > 0, usual, 0.0))
    return conjugate_gradients(levels, right, start, tolerance, limit)


def sources(across: Float[np.ndarray, "h w_less_1"], down: Float[np.ndarray, "h_less_1 w"]) -> Float[np.ndarray, "h w"]:
    """What flows into each place less what flows out: the transpose of the forward differences."""
    out = np.zeros((across.shape[0], down.shape[1]))
    out[:, 1:] += across
    out[:, :-1] -= across
    out[1:] += down
    out[:-1] -= down
    return out


def grid_levels(
    weight: Float[np.ndarray, "h w"], across: Float[np.ndarray, "h w-1"], down: Float[np.ndarray, "h-1 w"]
) -> list[GridLevel]:
    """Ever coarser grids, two by two places one: weights are summed, and so are the edges between, halved since values
    of neighbours are twice as far apart."""
    levels = []
    while True:
        levels.append(_level(weight, across, down))
        if min(weight.shape) <= SMALLEST:
            return levels
        (h, w), fine = weight.shape, weight
        weight = np.empty(((h + 1) // 2, (w + 1) // 2))
        kernel.sum_fours(fine, weight)
        across = np.add.reduceat(across[:, 1::2], np.arange(0, h, 2), axis=0) / 2
        down = np.add.reduceat(down[1::2], np.arange(0, w, 2), axis=1) / 2


def _level(weight: np.ndarray, across: np.ndarray, down: np.ndarray) -> GridLevel:
    diagonal = weight.astype(float)
    diagonal[:, :-1] += across
    diagonal[:, 1:] += across
    diagonal[:-1] += down
    diagonal[1:] += down
    inverse = np.divide(1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal > 0)
    room = np.zeros((2, *weight.shape))
    edges = (np.ascontiguousarray(across), np.ascontiguousarray(down))
    return GridLevel(np.ascontiguousarray(weight), *edges, inverse, room[0], room[1])


def v_cycle(levels: list[GridLevel]) -> None:
    """`values` of the first level, about the solution for its `right`: linear and symmetric in it."""
    level, *coarser = levels
    edges = (level.across, level.down)
    level.values[:] = 0.0
    for _ in range(1 if coarser else COARSEST_ROUNDS):
        for colour in (0, 1):
            kernel.relax(level.values, level.right, *edges, level.inverse, colour)
    if coarser:
        left = np.empty_like(level.values)
        kernel.applied(level.values, level.weight, *edges, left)
        kernel.sum_fours(level.right - left, coarser[0].right)
        v_cycle(coarser)
        kernel.add_to_fours(level.values, coarser[0].values)
    for _ in range(1 if coarser else COARSEST_ROUNDS):
        for colour in (1, 0):
            kernel.relax(level.values, level.right, *edges, level.inverse, colour)


def conjugate_gradients(
    levels: list[GridLevel], right: Float[np.ndarray, "h w"], start: Float[np.ndarray, "h w"], tolerance: float,
    limit: int,
) -> GridSolution:  # fmt: skip
    """Until the preconditioned residual is `tolerance` of the right side's."""
    fine = levels[0]
    f, moved = start, np.empty_like(start)

    def conditioned(residual: np.ndarray) -> np.ndarray:
        fine.right[:] = residual
        v_cycle(levels)
        return fine.values

    kernel.applied(f, fine.weight, fine.across, fine.down, moved)
    residual = right - moved
    size = max(float(np.sqrt(np.vdot(right, conditioned(right)))), 1e-30)
    direction, energy = np.zeros_like(f), 1.0
    for iteration in range(limit):
        step = conditioned(residual)
        fresh = float(np.vdot(residual, step))
        if np.sqrt(max(fresh, 0.0)) <= tolerance * size:
            return GridSolution(f, iteration, True)
        direction = step + (fresh / energy) * direction
        kernel.applied(direction, fine.weight, fine.across, fine.down, moved)
        along = fresh / float(np.vdot(direction, moved))
        f = f + along * direction
        residual = residual - along * moved
        energy = fresh
    return GridSolution(f, limit, False)
