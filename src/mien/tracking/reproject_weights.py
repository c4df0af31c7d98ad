"""Blendshape coefficients solved anew on the final mesh (Li et al. 2013, sec. 6)."""

import numpy as np
from jaxtyping import Float

from .._kernels.boxls import solve_chunk
from .._kernels.mix import products
from ..solve.boxls import TOLERANCE
from .model import POINTS, TrackingModel

REGULAR = 1e-9
"""Part of the mean diagonal added where the plain system could not be solved to the solver's tolerance."""


class WeightReprojection:
    """min |b0 + B x - v4|^2 over 0..1 on the front, every vertex by its share of the area."""

    def __init__(self, model: TrackingModel, ridge: float = 8.0, near_weight: float = 40.0):
        """`ridge` and `near_weight` weigh x^2 and the squared change from `near`, as in the blendshape fit."""
        self._model, self._near_weight, k = model, near_weight, model.shapes
        weighted = (model.basis * (POINTS * model.share)[:, None, None]).reshape(-1, k)
        self._right = np.ascontiguousarray(weighted.T)
        self._gram = (weighted.T @ model.basis.reshape(-1, k)).astype(np.float64)
        self._gram[range(k), range(k)] += ridge + near_weight

    def weights(self, vertices: Float[np.ndarray, "f 3"], near: Float[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
        """Coefficients for the front at `vertices` (mm); where the mesh does not say, those `near`."""
        moved = (vertices - self._model.neutral).astype(np.float32).ravel()
        right = products(self._right, moved) + self._near_weight * near
        return box_solve(self._gram, right, np.zeros(len(near)), np.ones(len(near)), near)[0]


def box_solve(
    gram: Float[np.ndarray, "k k"],
    linear: Float[np.ndarray, " k"],
    lower: Float[np.ndarray, " k"],
    upper: Float[np.ndarray, " k"],
    warm: Float[np.ndarray, " k"],
) -> tuple[Float[np.ndarray, " k"], float]:
    """`mien.solve.boxls.box_least_squares` for one frame, in the calling thread: values, breach of optimality.

    A breach above the solver's tolerance is tried again from the bounds' inside with a little more on the diagonal. A
    system that is not finite leaves `warm` as it is, at an infinite breach.
    """
    if not (np.isfinite(gram).all() and np.isfinite(linear).all()):
        return np.clip(warm, lower, upper), float("inf")
    values, breach = _solved(gram, linear, lower, upper, warm)
    if breach <= TOLERANCE:
        return values, breach
    more = gram + REGULAR * np.trace(gram) / len(gram) * np.eye(len(gram))
    again, left = _solved(more, linear, lower, upper, np.clip(np.zeros(len(linear)), lower, upper))
    return (again, left) if left < breach else (values, breach)


def _solved(gram, linear, lower, upper, warm) -> tuple[Float[np.ndarray, " k"], float]:
    values, breach, pivots = np.empty((1, len(linear))), np.empty(1), np.empty(1, np.int64)
    solve_chunk(0, 1, gram[None], linear[None], lower, upper, warm[None], TOLERANCE, values, breach, pivots)
    return values[0], float(breach[0])
