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
    ridge: float = 5.0
    """mm^2: price of a squared weight, so that shapes no marker sees stay at rest, and those that markers cannot tell
    apart share what they explain."""
    still_power: float = 2.0
    """Head pose is told by markers as (how far shapes move them)^-this; 0: by all alike."""
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

    Raises:
        ValueError: a model or poses that are not finite.
        BadInput: no frame shows enough markers.
    """
    if not (np.isfinite(T_lab_face.rotation).all() and np.isfinite(T_lab_face.translation).all()):
        raise ValueError("T_lab_face: expected finite poses, got NaN or infinity")
    if not (np.isfinite(model.neutral).all() and np.isfinite(model.shapes).all()):
        raise ValueError("model: expected finite places and shapes, got NaN or infinity; leave unseen markers out")
    M = np.eye(3) if metric is None else metric
    seen = visible(positions)
    tracked = seen.sum(axis=1) >= config.fewest
    T = hold(T_lab_face, tracked)
    used = seen & tracked[:, None]
    weights = np.zeros((len(positions), len(model.shapes))) if warm is None else warm
    residuals, converged = np.full(seen.shape, np.nan), True
    for _ in range(config.rounds):
        r = np.nan_to_num(T.inverse().apply(positions) - model.neutral)
        G, b = normal_equations(model.jacobian(), M, r, used)
        still = normal_equations(model.jacobian(), M, r, used, stillness(model, config.still_power))
        weights, pose, converged = _inner(G, b, still, weights, rate, config)
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
    worth: Float[np.ndarray, " markers"] | None = None,
) -> tuple[Float[np.ndarray, "frames columns columns"], Float[np.ndarray, "frames columns"]]:
    """A'MA and A'Mr for every frame. Frames differ only by the markers they miss, whose blocks are taken off."""
    MA = np.einsum("ab,mbk->mak", metric, jacobian)
    if worth is not None:
        MA = worth[:, None, None] * MA
    blocks = np.einsum("mak,mal->mkl", jacobian, MA)
    t, m, _ = residuals.shape
    missing = sp.csr_array((~used).astype(float)) @ blocks.reshape(m, -1)
    grams = (blocks.sum(axis=0).ravel() - missing).reshape(t, *blocks.shape[1:])
    b = (residuals * used[..., None]).reshape(t, -1) @ MA.reshape(3 * m, -1)
    return grams, b


def stillness(model: MarkerModel, power: float) -> Float[np.ndarray, " markers"]:
    """How much each marker tells of the skull, 0..1: (how far shapes move it)^-power, the stillest tenth at 1.

    Forehead, bridge of the nose and sides hold still where lips and jaw run away: a smile is no lift of the head
    (Beeler and Bradley 2014, who hold to skull and nose where they know them).
    """
    moved = np.sqrt((model.shapes**2).sum(axis=(0, 2)))
    floor = max(float(np.quantile(moved, 0.1)), 1e-6)
    return (floor / np.maximum(moved, floor)) ** power


def without_pose(
    G: Float[np.ndarray, "frames columns columns"],
    b: Float[np.ndarray, "frames columns"],
    G_still: Float[np.ndarray, "frames columns columns"] | None = None,
    b_still: Float[np.ndarray, "frames columns"] | None = None,
) -> tuple[Float[np.ndarray, "frames k k"], Float[np.ndarray, "frames k"], Float[np.ndarray, "frames 6 c"]]:
    """The normal equations with the pose increment p eliminated, and how to get it back: p = back (1, -weights).

    p is the least-squares pose under the second pair, whose markers are weighted by how still they are: p = p_0 - B w.
    What is left of the first pair is |r - J p_0 - (A - J B) w|^2. Without a second pair it is the Schur complement.
    """
    k = b.shape[1] - POSE
    H, h = (G, b) if G_still is None or b_still is None else (G_still, b_still)
    floor = 1e-9 * (1 + np.trace(H[:, k:, k:], axis1=1, axis2=2))
    pose = H[:, k:, k:] + floor[:, None, None] * np.eye(POSE)
    back = np.linalg.solve(pose, np.concatenate([h[:, k:, None], H[:, k:, :k]], axis=2))
    B, p0 = back[:, :, 1:], back[:, :, :1]
    AJ, JJ, Bt = G[:, :k, k:], G[:, k:, k:], np.swapaxes(B, 1, 2)
    cross = AJ @ B
    reduced = G[:, :k, :k] - cross - np.swapaxes(cross, 1, 2) + Bt @ JJ @ B
    left = b[:, :k, None] - AJ @ p0 - Bt @ (b[:, k:, None] - JJ @ p0)
    return reduced, left[..., 0], back


def _inner(G, b, still, weights, rate, config):
    """One box-constrained solve of the whole take: weights, the pose increments that go with them, convergence."""
    G, b, back = without_pose(G, b, *still)
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
