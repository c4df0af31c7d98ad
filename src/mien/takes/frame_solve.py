"""Weights and head pose for every frame of a marker take, given where the markers sit on the rig."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float

from ..clip import visible
from ..solve.smooth import smooth_box_least_squares
from ..transforms import Transform, rotation_from_vector
from .marker_model import MarkerModel
from .stabilise import hold, last_tracked

POSE = 6
"""Columns for the pose increment: rotation vector, translation."""

SETTLED_RAD, SETTLED_MM = 2e-4, 0.02
"""A pose increment below both, in every frame, ends the rounds: a fifth of what a marker jitters."""


@dataclass(frozen=True)
class SolveConfig:
    """What holds the weights back."""

    sparsity: float = 2.0
    """mm^2: price of a unit of weight (l1), which keeps few shapes on at once; 0 switches it off."""
    smoothness: float = 100.0
    """mm^2: price of a weight's squared change between frames 1/30 s apart; 0 switches it off."""
    ridge: float = 1.0
    """mm^2: price of a squared weight, so that shapes no marker sees stay at rest."""
    rounds: int = 3
    """Gauss-Newton rounds: weights and pose increments together, then the pose is composed."""
    outlier: float = 4.0
    """A sample is left out of its frame when its residual is this many times the take's robust spread; inf: never."""
    outlier_floor_mm: float = 2.0
    """... and at least this large, mm."""
    fewest: int = 4
    """Frames with fewer markers are not tracked."""


@dataclass(frozen=True)
class FrameSolve:
    """What `solve_frames` found."""

    weights: Float[np.ndarray, "frames shapes"]
    """In 0..1."""
    T_lab_face: Transform
    """Head pose, one a frame."""
    residuals: Float[np.ndarray, "frames markers"]
    """Distance from marker to model, mm; NaN where the marker was not seen."""
    used: Bool[np.ndarray, "frames markers"]
    """Samples that counted: seen and no outlier."""
    tracked: Bool[np.ndarray, " frames"]
    """Frames with enough markers; the others hold the last value."""
    converged: bool
    """Whether the inner solver met its tolerance in the last round."""


def solve_frames(
    model: MarkerModel,
    positions: Float[np.ndarray, "frames markers 3"],
    T_lab_face: Transform,
    rate: float,
    metric: Float[np.ndarray, "3 3"] | None = None,
    config: SolveConfig = SolveConfig(),
    warm: Float[np.ndarray, "frames shapes"] | None = None,
) -> FrameSolve:
    """Head pose and box-constrained, sparse, smooth weights for all frames at once.

    Minimises sum_t sum_i |p_i(w_t) + pose increment - x_ti|_M^2 + l1 + ridge + smoothness over 0 <= w <= 1, with the
    pose increment as six free columns beside the shapes: Huang 2011, eq. 12, with a prior where the paper has none.

    Args:
        positions: lab frame, mm; NaN where not seen.
        T_lab_face: start; `mien.takes.stabilise` gives a good one.
        metric: M, in face space; identity unless the take knows less about one direction than the others.
        warm: weights to start from; saves time, changes nothing.
    """
    M = np.eye(3) if metric is None else metric
    seen = visible(positions)
    tracked = seen.sum(axis=1) >= config.fewest
    T = hold(T_lab_face, tracked)
    used = seen & tracked[:, None]
    weights = np.zeros((len(positions), len(model.shapes))) if warm is None else warm
    residuals, converged = np.full(seen.shape, np.nan), True
    for _ in range(config.rounds):
        r = np.nan_to_num(T.inverse().apply(positions) - model.rest)
        G, b = normal_equations(model.jacobian(), M, r, used)
        weights, pose, converged = _inner(G, b, weights, rate, config)
        T = T @ Transform(rotation_from_vector(pose[:, :3]), pose[:, 3:])
        settled = np.abs(pose[:, :3]).max() < SETTLED_RAD and np.abs(pose[:, 3:]).max() < SETTLED_MM
        residuals = np.linalg.norm(T.inverse().apply(positions) - model.points(weights), axis=2)
        before, used = used, seen & tracked[:, None] & ~_outliers(residuals, config)
        if settled and np.array_equal(before, used):
            break
    weights, T = weights[last_tracked(tracked)], hold(T, tracked)
    return FrameSolve(weights, T, residuals, used, tracked, converged)


def normal_equations(
    jacobian: Float[np.ndarray, "markers 3 columns"],
    metric: Float[np.ndarray, "3 3"],
    residuals: Float[np.ndarray, "frames markers 3"],
    used: Bool[np.ndarray, "frames markers"],
) -> tuple[Float[np.ndarray, "frames columns columns"], Float[np.ndarray, "frames columns"]]:
    """A'MA and A'Mr for every frame. Frames differ only by the markers they miss, whose blocks are taken off."""
    MA = np.einsum("ab,mbk->mak", metric, jacobian)
    blocks = np.einsum("mak,mal->mkl", jacobian, MA)
    t, m, _ = residuals.shape
    missing = sp.csr_array((~used).astype(float)) @ blocks.reshape(m, -1)
    grams = (blocks.sum(axis=0).ravel() - missing).reshape(t, *blocks.shape[1:])
    b = (residuals * used[..., None]).reshape(t, -1) @ MA.reshape(3 * m, -1)
    return grams, b


def without_pose(
    G: Float[np.ndarray, "frames columns columns"], b: Float[np.ndarray, "frames columns"]
) -> tuple[Float[np.ndarray, "frames k k"], Float[np.ndarray, "frames k"], Float[np.ndarray, "frames 6 c"]]:
    """The normal equations with the pose increment eliminated (Schur complement), and how to get it back.

    The third array maps (1, -weights) to the pose increment that goes with them.
    """
    k = b.shape[1] - POSE
    floor = 1e-9 * (1 + np.trace(G[:, k:, k:], axis1=1, axis2=2))
    pose = G[:, k:, k:] + floor[:, None, None] * np.eye(POSE)
    back = np.linalg.solve(pose, np.concatenate([b[:, k:, None], G[:, k:, :k]], axis=2))
    reduced = G[:, :k, :k] - G[:, :k, k:] @ back[:, :, 1:]
    return reduced, b[:, :k] - (G[:, :k, k:] @ back[:, :, :1])[..., 0], back


def _inner(G, b, weights, rate, config):
    """One box-constrained solve of the whole take: weights, the pose increments that go with them, convergence."""
    G, b, back = without_pose(G, b)
    k = b.shape[1]
    result = smooth_box_least_squares(
        G + config.ridge * np.eye(k),
        b,
        lower=0.0,
        upper=1.0,
        l1=config.sparsity,
        mu=config.smoothness * (rate / 30.0),
        warm=weights,
    )
    pose = back[:, :, 0] - np.einsum("tpk,tk->tp", back[:, :, 1:], result.values)
    return result.values, pose, bool(np.all(result.converged))


def _outliers(residuals: np.ndarray, config: SolveConfig) -> np.ndarray:
    """Samples far beyond their marker's usual residual: swapped labels, ghosts."""
    if not np.isfinite(config.outlier):
        return np.zeros(residuals.shape, bool)
    spread = 1.4826 * np.median(residuals[np.isfinite(residuals)])
    return residuals > max(config.outlier * spread, config.outlier_floor_mm)
