"""Blendshape coefficients solved anew on the final mesh (Li et al. 2013, sec. 6)."""

import numpy as np
from jaxtyping import Float

from .._kernels.boxls import solve_chunk
from .._kernels.mix import products
from ..solve.boxls import TOLERANCE
from .model import POINTS, TrackingModel


class Resolver:
    """min |b0 + B x - v4|^2 over 0..1 on the front, every vertex by its share of the area."""

    def __init__(self, model: TrackingModel, ridge: float = 8.0, still: float = 40.0):
        """`ridge` and `still` are weights of x^2 and of the squared change from `near`, as in the blendshape fit."""
        self._model, self._still, k = model, still, model.shapes
        weighted = (model.basis * (POINTS * model.share)[:, None, None]).reshape(-1, k)
        self._right = np.ascontiguousarray(weighted.T)
        self._gram = (weighted.T @ model.basis.reshape(-1, k)).astype(np.float64)
        self._gram[range(k), range(k)] += ridge + still

    def weights(self, vertices: Float[np.ndarray, "f 3"], near: Float[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
        """Coefficients for the front at `vertices` (mm); where the mesh does not say, those `near`."""
        moved = (vertices - self._model.neutral).astype(np.float32).ravel()
        right = products(self._right, moved) + self._still * near
        return box_solve(self._gram, right, np.zeros(len(near)), np.ones(len(near)), near)


def box_solve(
    gram: Float[np.ndarray, "k k"],
    linear: Float[np.ndarray, " k"],
    lower: Float[np.ndarray, " k"],
    upper: Float[np.ndarray, " k"],
    warm: Float[np.ndarray, " k"],
) -> Float[np.ndarray, " k"]:
    """`mien.solve.boxls.box_least_squares` for one frame, in the calling thread."""
    values, breach, pivots = np.empty((1, len(linear))), np.empty(1), np.empty(1, np.int64)
    solve_chunk(0, 1, gram[None], linear[None], lower, upper, warm[None], TOLERANCE, values, breach, pivots)
    return values[0]
