"""Box-constrained least squares over a whole take, smooth in time."""

import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_solve_banded, cholesky_banded

from .._kernels.boxls_smooth import smooth_band, smooth_slope
from .boxls import BoxResult, box, box_least_squares, stacked

TOLERANCE = 1e-8
"""Breach of the optimality conditions that is let pass, relative to the largest slope of the cost."""

MOST_STEPS = 100
MOST_HALVINGS = 12
RIDGE = 1e-12
"""Added to the Newton matrix, relative to its largest diagonal entry; the cost itself stays as it is."""


def smooth_box_least_squares(
    gram: Float[np.ndarray, "k k"] | Float[np.ndarray, "frames k k"],
    linear: Float[np.ndarray, "frames k"],
    lower: Float[np.ndarray, " k"] | float = 0.0,
    upper: Float[np.ndarray, " k"] | float = 1.0,
    l1: Float[np.ndarray, " k"] | float = 0.0,
    mu: float = 0.0,
    nu: float = 0.0,
    warm: Float[np.ndarray, "frames k"] | None = None,
) -> BoxResult:
    """Minimise, over all frames at once and with lower <= w <= upper,

        sum_t 1/2 w_t'G_t w_t - b_t'w_t + l1'|w_t| + mu/2 |w_t - w_t-1|^2 + nu/2 |w_t-1 - 2 w_t + w_t+1|^2.

    Projected Newton steps (Bertsekas 1982): the variables at a bound that the slope holds there are set aside, the
    rest is solved for by one banded Cholesky factorisation over the whole take, and the step is bent into the box,
    halved until the cost falls. Starts from the frames solved one by one, unless `warm` is given. The result does not
    depend on the start beyond the tolerance where the whole cost is strictly convex.

    Args:
        gram, linear, lower, upper, l1: as `box_least_squares` takes them.
        mu: weight of the speed, in units of gram.
        nu: weight of the acceleration, in units of gram.
        warm: where to start.

    Raises:
        ValueError: as `box_least_squares`; negative mu or nu.
    """
    if mu < 0 or nu < 0:
        raise ValueError(f"mu, nu: expected >= 0, got {mu} and {nu}")
    if warm is not None and (warm.shape != linear.shape or not np.isfinite(warm).all()):
        raise ValueError(f"warm: expected finite numbers of shape {linear.shape}, got {warm.shape}")
    if mu == nu == 0:
        return box_least_squares(gram, linear, lower, upper, l1, warm)
    frames, k = linear.shape
    low, high, sparse = box(k, lower, upper, l1)
    grams, target = stacked(gram, linear), np.ascontiguousarray(linear - sparse)
    start = box_least_squares(gram, linear, low, high, sparse).values if warm is None else warm
    return _newton(grams, target, time_links(frames, mu, nu), low, high, np.clip(start, low, high))


def time_links(frames: int, mu: float, nu: float) -> Float[np.ndarray, "3 frames"]:
    """The three diagonals of mu D1'D1 + nu D2'D2, where D1 and D2 take first and second differences in time."""
    links = np.zeros((3, frames))
    for weight, stencil in ((mu, (1.0, -1.0)), (nu, (1.0, -2.0, 1.0))):
        rows = frames - len(stencil) + 1
        for a, left in enumerate(stencil):
            for b, right in enumerate(stencil[a:]):
                links[b, a : a + max(rows, 0)] += weight * left * right
    return links


def _newton(grams, target, links, low, high, values):
    values = np.ascontiguousarray(values, dtype=np.float64)
    down = smooth_slope(grams, target, links, values)
    scale = max(np.abs(target).max(), np.abs(down).max(), 1e-300)
    held = _at_rest(values, down, low, high)
    for steps in range(MOST_STEPS + 1):
        breach = np.where(_at_rest(values, down, low, high), 0.0, np.abs(down)).max(axis=1) / scale
        if not (breach > TOLERANCE).any() or steps == MOST_STEPS:
            break
        step = _newton_step(grams, links, ~held, down)
        goal = values + step
        values, down, fell = _fall(grams, target, links, low, high, values, step, down)
        stopped = ((goal < low) & (values <= low)) | ((goal > high) & (values >= high))
        held = stopped | (held & (_at_rest(values, down, low, high) | (not fell)))
    return BoxResult(values, np.less_equal(breach, TOLERANCE), np.full(len(values), steps), breach)


def _at_rest(values, down, low, high):
    """Variables at a bound to which the slope holds them."""
    return ((down <= 0) & (values <= low)) | ((down >= 0) & (values >= high))


def _newton_step(grams, links, free, down):
    """-H_FF^-1 gradient_F on the free variables, 0 elsewhere."""
    step = np.zeros(down.shape)
    if free.any():
        order = (np.cumsum(free.ravel()) - free.ravel()).reshape(free.shape)
        ridge = RIDGE * (np.diagonal(grams, axis1=1, axis2=2).max() + links[0].max())
        band = smooth_band(grams, links, free, order, _width(free, order, links), ridge)
        factor = cholesky_banded(band.T, overwrite_ab=True, lower=True, check_finite=False)
        step[free] = cho_solve_banded((factor, True), down[free], overwrite_b=True, check_finite=False)
    return step


def _width(free, order, links):
    """How far apart two coupled free variables are numbered, at most."""
    widths = [int(free.sum(axis=1).max()) - 1]
    for d in (1, 2):
        both = free[:-d] & free[d:] & (links[d, : len(free) - d, None] != 0)
        widths.append(int(np.where(both, order[d:] - order[:-d], 0).max(initial=0)))
    return max(widths)


def _fall(grams, target, links, low, high, values, step, down):
    """Follow the step, bent into the box and halved until the cost falls enough: values, slope, whether it fell."""
    for halving in range(MOST_HALVINGS):
        tried = np.clip(values + 0.5**halving * step, low, high)
        slope = smooth_slope(grams, target, links, tried)
        change = tried - values
        gain = 0.5 * np.vdot(change, down + slope)  # exact: the cost is quadratic
        if gain > 0 and gain >= 1e-4 * np.vdot(change, down):
            return tried, slope, True
    return values, down, False
