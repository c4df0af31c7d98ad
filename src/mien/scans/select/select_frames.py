"""The fewest frames of a take from which all others can be mixed: the expressions to scan."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ..._kernels.select import LANES, ceilings, residual_products, restate, weigh
from ...errors import BadInput
from ...progress import SILENT, Progress

BATCH = 4 * LANES
"""Candidates weighed between two looks at the best so far."""

PANEL = 256
"""Candidates whose products with all residuals are held at once."""

STRIDE = 6
"""In longer takes, frames apart whose bounds are worked out first; neighbours bound those between, if that will do."""

INNER_FRAMES = 4096
"""Takes up to this long have the inner products of all pairs of frames worked out once (134 MB)."""

ROUNDING = 1e-13
"""Directions of the take with less than this share of its largest variance are rounding."""

STRONGEST_SHARE = 0.1
"""Share of the frames, those farthest from the take's mean face, whose error is bounded by itself."""


@dataclass(frozen=True)
class SelectConfig:
    """When to stop."""

    tolerance: float = 0.003
    """Mean marker error to reach, as a part of the diagonal of the box of all markers in all frames (the paper's)."""
    strongest: float = 0.12
    """... and that of the strongest tenth of the frames, as a part of how far they are from the take's mean face: a
    mean over calm frames hides expressions. inf: the paper's stop alone."""
    max_frames: int = 50
    """Stop here even if the tolerance is not met."""


@dataclass(frozen=True)
class Selection:
    """Frames to scan, in the order in which they were chosen."""

    frames: Int[np.ndarray, " chosen"]
    """Counted from 0."""
    errors: Float[np.ndarray, " chosen"]
    """Mean distance of a marker from its place, mm, with the first 1, 2, ... of the frames."""
    strongest: Float[np.ndarray, " chosen"]
    """The same over the strongest tenth of the frames, as a part of how far they are from the take's mean face."""
    tolerance: float
    strongest_tolerance: float
    diagonal: float
    """Millimetres: of the box of all markers in all frames."""
    weights: Float[np.ndarray, "frames chosen"]
    """Every frame of the take as a mix of the chosen ones; not negative."""
    origin: Float[np.ndarray, "3"]
    """The point about which the weights scale, mm: the mean of all markers in all frames."""

    @property
    def relative(self) -> Float[np.ndarray, " chosen"]:
        """Errors as parts of the diagonal."""
        return self.errors / self.diagonal

    @property
    def reached(self) -> bool:
        """Whether both tolerances were met."""
        return bool(self.relative[-1] < self.tolerance and self.strongest[-1] < self.strongest_tolerance)


def select_frames(
    positions: Float[np.ndarray, "frames markers 3"],
    config: SelectConfig = SelectConfig(),
    progress: Progress = SILENT,
) -> Selection:
    """Choose frames greedily until all others are non-negative mixes of them (Huang et al. 2011, eq. 3, algorithm 1).

    In every round the frame is added that leaves the least sum of squared residuals over all frames, each of them
    solved exactly by non-negative least squares; all frames are candidates and none is left out but by proof. The stop
    is the mean over frames and markers of the Euclidean distance, as a part of the diagonal; not in the paper, the
    strongest tenth of the frames must be met too.

    Positions are absolute, as in the paper, so the weights of a frame come out near a sum of one without being told.
    How near depends on the origin; it is put in the middle of all markers, so that neither the lab's nor the head's
    frame has a say and a sum off one scales the face about its middle.

    Candidates are pruned by a bound that holds whatever the active sets do. Let r be frame t's residual on the chosen
    frames B, so that B'r <= 0 and r is orthogonal to B w; let n be the part of candidate c outside the span of B, and
    g = c.r > 0. Then q = r - g/|n|^2 n has B'q = B'r <= 0 and c.q = 0: it is feasible for the dual of the enlarged
    problem, max 2x.q - |q|^2, whose optimum is the new squared error. With x.r = |r|^2 and x.n = r.n = g, this value is
    |r|^2 - g^2/|n|^2. Hence **c takes at most g^2/|n|^2 off frame t**, and nothing where g <= 0. Where only B's free
    columns P meet the slope condition after the step, the same holds with n taken outside the span of P; where the
    weights stay positive too, it is the exact gain.

    Args:
        positions: markers in the head's frame, mm, gaps filled.
        progress: is told the frames chosen, of `max_frames`.

    Raises:
        BadInput: gaps are left, there are fewer than 2 frames or no markers, all markers stand in one point, or the
            config asks for nothing.
    """
    _check(positions, config)
    frames = len(positions)
    origin = positions.mean(axis=(0, 1))
    X = (positions - origin).reshape(frames, -1)
    diagonal = float(np.linalg.norm(np.ptp(positions.reshape(-1, 3), axis=0)))
    Y = _compact(X)
    inner = Y @ Y.T if frames <= INNER_FRAMES else None
    strong, moved = strongest_frames(positions)
    chosen, errors, strongest = [], [], []
    state = _restate(Y, chosen, np.zeros((frames, 0)))
    while len(chosen) < min(config.max_frames, frames):
        progress.update("selecting frames", len(chosen), config.max_frames)
        chosen.append(_best_candidate(Y, inner, chosen, state))
        state = _restate(Y, chosen, np.pad(state.weights, ((0, 0), (0, 1))))
        error = _marker_errors(X - state.weights @ X[chosen])
        errors.append(float(error.mean()))
        strongest.append(float(error[strong].mean() / moved))
        if errors[-1] < config.tolerance * diagonal and strongest[-1] < config.strongest:
            break
    progress.update("selecting frames", len(chosen), len(chosen))
    curve = np.array(chosen), np.array(errors), np.array(strongest)
    return Selection(*curve, config.tolerance, config.strongest, diagonal, state.weights, origin)


def _marker_errors(missing: Float[np.ndarray, "frames coordinates"]) -> Float[np.ndarray, " frames"]:
    """Mean distance of the markers from their places, frame by frame, mm."""
    return np.linalg.norm(missing.reshape(len(missing), -1, 3), axis=2).mean(axis=1)


def strongest_frames(positions: Float[np.ndarray, "frames markers 3"]) -> tuple[Int[np.ndarray, " s"], float]:
    """The tenth of the frames that are farthest from the take's mean face, and how far they are in the mean, mm."""
    away = np.linalg.norm(positions - positions.mean(axis=0), axis=2).mean(axis=1)
    count = max(1, round(STRONGEST_SHARE * len(positions)))
    strong = np.argsort(-away, kind="stable")[:count]
    return strong, max(float(away[strong].mean()), np.finfo(float).tiny)


def _check(positions, config):
    if positions.shape[0] < 2 or positions.shape[1] < 1:
        raise BadInput(f"a take of {positions.shape[0]} frames and {positions.shape[1]} markers; 2 and 1 are needed")
    if not np.isfinite(positions).all():
        t, k = np.argwhere(~np.isfinite(positions).all(axis=2))[0]
        raise BadInput(f"marker {k} is missing in frame {t}; fill the gaps or leave out the marker before selecting")
    if not np.ptp(positions.reshape(-1, 3), axis=0).any():
        raise BadInput("all markers stand in one point in all frames; is this a take of a face?")
    if not (config.tolerance > 0 and config.strongest > 0 and config.max_frames >= 1):
        raise BadInput(
            f"tolerance {config.tolerance}, strongest {config.strongest} and max_frames {config.max_frames}: give "
            "tolerances above 0 and at least 1 frame"
        )


def _compact(X):
    """The rows of X in as few coordinates as carry them: the same inner products."""
    values, vectors = np.linalg.eigh(X.T @ X)
    return np.ascontiguousarray(X @ vectors[:, values > ROUNDING * values[-1]])


@dataclass(frozen=True)
class _State:
    """All frames solved on the chosen ones."""

    gram: np.ndarray
    linear: np.ndarray
    weights: np.ndarray
    slack: np.ndarray
    free: np.ndarray
    swept: np.ndarray
    residuals: np.ndarray


def _restate(Y, chosen, weights):
    basis = Y[chosen]
    gram, linear = basis @ basis.T, np.ascontiguousarray(Y @ basis.T)
    weights, slack, free, swept = restate(gram, linear, np.ascontiguousarray(weights))
    return _State(gram, linear, weights, slack, free, swept, Y - weights @ basis)


@dataclass(frozen=True)
class _Round:
    """What is the same for all candidates of a round, and what is known of each."""

    Y: np.ndarray
    inner: np.ndarray | None
    heights: np.ndarray
    mixes: np.ndarray
    own: np.ndarray
    apart: np.ndarray
    errors: np.ndarray
    order: np.ndarray
    state: _State


def _best_candidate(Y, inner, chosen, state):
    """The frame whose addition leaves the least summed squared error; the earliest of equals.

    Bounds first, in a long take of every `STRIDE`-th frame alone; then the most promising are weighed; then all whose
    bounds still reach the best, best bounds first.
    """
    errors, own = np.einsum("td,td->t", state.residuals, state.residuals), np.einsum("td,td->t", Y, Y)
    apart, order = _apart(Y, chosen, own), np.argsort(-errors, kind="stable")
    turn = _Round(Y, inner, state.linear, np.ascontiguousarray(state.weights.T), own, apart, errors, order, state)
    stride = STRIDE if inner is None else 1
    first = np.arange(0, len(Y), stride)
    bounds, squares = _ceilings(turn, first)
    top = first[np.argsort(-bounds, kind="stable")[:BATCH]]
    best, found = _weigh_all(turn, top, 0.0, -1)
    ceiling = bounds if inner is not None else _between(turn, first, bounds, squares, best)
    ceiling[chosen], ceiling[top] = -1.0, -1.0
    candidates = np.argsort(-ceiling, kind="stable")
    return _weigh_all(turn, candidates[ceiling[candidates] >= best], best, found, ceiling)[1]


def _products(turn, candidates):
    """Inner products of candidates with all residuals: through those with all frames where these are at hand."""
    if turn.inner is None:
        return turn.Y[candidates] @ turn.state.residuals.T
    return residual_products(turn.inner, turn.heights, turn.mixes, candidates)


def _ceilings(turn, candidates):
    """Bounds of the candidates' gains, and the sums of their squared positive products with the residuals."""
    bounds, squares = np.empty(len(candidates)), np.empty(len(candidates))
    for i in range(0, len(candidates), PANEL):
        part = slice(i, i + PANEL)
        products = _products(turn, candidates[part])
        bounds[part], squares[part] = ceilings(products, turn.apart[candidates[part]], turn.errors)
    return bounds, squares


def _between(turn, first, bounds, squares, best):
    """Bounds for all frames, of which `first` have theirs: from the nearest of these where that shows enough.

    With |.| the norm over frames t: |(x.r_t)+| <= |(y.r_t)+| + |(x - y).r_t|.
    """
    frames = np.arange(len(turn.Y))
    near = np.minimum((frames + STRIDE // 2) // STRIDE, len(first) - 1)
    difference = turn.Y - turn.Y[first[near]]
    spread = turn.state.residuals.T @ turn.state.residuals
    apart = np.sqrt(np.maximum(np.einsum("td,td->t", difference @ spread, difference), 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        ceiling = np.where(turn.apart > 0, (np.sqrt(squares[near]) + apart) ** 2 / turn.apart, np.inf)
    ceiling[first] = bounds
    rest = np.setdiff1d(frames[ceiling >= best], first)
    ceiling[rest] = _ceilings(turn, rest)[0]
    return ceiling


def _weigh_all(turn, candidates, best, found, ceiling=None):
    """Weigh candidates in batches: the best gain and its frame, the earliest of equals."""
    for i in range(0, len(candidates), BATCH):
        batch = candidates[i : i + BATCH]
        if ceiling is not None:
            batch = batch[ceiling[batch] >= best]
        if not len(batch):
            break
        gains = _weigh(turn, batch, best)
        top = gains.max()
        if top >= best:
            winner = int(batch[gains == top].min())
            found = winner if top > best or found < 0 else min(found, winner)
            best = top
    return best, found


def _weigh(turn, batch, best):
    state = turn.state
    return weigh(
        _products(turn, batch), turn.heights[batch], turn.own[batch], turn.apart[batch],
        turn.order, turn.errors, turn.own.max(),
        state.gram, state.weights, state.slack, state.free, state.swept, best,
    )  # fmt: skip


def _apart(Y, chosen, own):
    """Squared length of every row outside the span of the chosen ones; 0 where it is rounding."""
    basis = np.linalg.qr(Y[chosen].T)[0]
    outside = Y - (Y @ basis) @ basis.T
    squared = np.einsum("td,td->t", outside, outside)
    return np.where(squared > 1e-11 * own, squared, 0.0)
