"""Box-constrained least squares on Gram matrices: a primal active set, exact, batched over frames."""

from typing import no_type_check

import numba as nb
import numpy as np

from ._spread import spread

MATHS = {"reassoc", "contract", "arcp", "nsz"}
"""Fast arithmetic that still knows infinity and NaN."""

DEPENDENT = 1e-11
"""A column whose part outside the free ones is smaller than this (squared, relative) counts as dependent on them."""

CHUNK = 32
"""Frames in a row that one thread takes, each warm-started from the one before; fixed, so results do not depend on
the number of threads."""

REFINEMENTS = 8
"""How often a frame's conditions are checked against the Gram matrix itself before it is given up."""


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def add(line, factor, row):
    """line += factor row, in place."""
    for i in range(line.size):
        line[i] += factor * row[i]


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def pivot(swept, i, sign):
    """Sweep variable `i` of the symmetric (k, k) tableau in (`sign` +1) or out (-1), in place.

    With F swept in, the tableau of G holds -inv(G_FF), inv(G_FF) G_FN and the Schur complement of F.
    """
    k = swept.shape[0]
    inverse = 1.0 / swept[i, i]
    for r in range(k):
        factor = swept[r, i] * inverse
        if r != i and factor != 0.0:
            add(swept[r], -factor, swept[i])
            swept[r, i] = sign * factor
    for c in range(k):
        swept[i, c] *= sign * inverse
    swept[i, i] = -inverse


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def slope(gram, linear, values, out):
    """out = linear - gram @ values, the direction of descent at `values`."""
    k = values.size
    for i in range(k):
        total = 0.0
        line = gram[i]
        for j in range(k):
            total += line[j] * values[j]
        out[i] = linear[i] - total


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def violation(down, values, free, lower, upper):
    """The largest breach of the optimality conditions: slope left in a free variable, or pointing off a bound."""
    worst = 0.0
    for i in range(values.size):
        if free[i] or (down[i] > 0 and values[i] < upper[i]) or (down[i] < 0 and values[i] > lower[i]):
            worst = max(worst, abs(down[i]))
    return worst


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def rebuild(gram, free, swept):
    """Sweep the free variables into a fresh copy of `gram`; those that depend on the others stop being free."""
    k = free.size
    for i in range(k):
        for j in range(k):
            swept[i, j] = gram[i, j]
    for i in range(k):
        if free[i]:
            if swept[i, i] > DEPENDENT * gram[i, i]:
                pivot(swept, i, 1.0)
            else:
                free[i] = False


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def minimise_free(swept, values, free, lower, upper, down, step):
    """Go to the minimum over the free variables; each that meets a bound on the way is fixed there. Returns pivots."""
    k = values.size
    pivots = 0
    while True:
        for r in range(k):
            step[r] = 0.0
        for f in range(k):
            if free[f] and down[f] != 0.0:
                add(step, -down[f], swept[f])
        reach, blocked = 1.0, -1
        for f in range(k):
            if free[f]:
                goal = values[f] + step[f]
                room = lower[f] - values[f] if goal < lower[f] else upper[f] - values[f]
                if (goal < lower[f] or goal > upper[f]) and room / step[f] < reach:
                    reach, blocked = room / step[f], f
        for r in range(k):
            if free[r]:
                values[r] += reach * step[r]
                down[r] *= 1.0 - reach
            else:
                down[r] += reach * step[r]
        if blocked < 0:
            return pivots
        values[blocked] = lower[blocked] if step[blocked] < 0 else upper[blocked]
        free[blocked] = False
        pivot(swept, blocked, -1.0)
        pivots += 1


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def entering(gram, swept, values, free, lower, upper, down, threshold):
    """The fixed variable whose release promises most, or -1 where no slope exceeds `threshold`."""
    best, found = 0.0, -1
    for i in range(values.size):
        wants = (down[i] > threshold and values[i] < upper[i]) or (down[i] < -threshold and values[i] > lower[i])
        if wants and not free[i]:
            promise = down[i] * down[i] / max(swept[i, i], DEPENDENT * gram[i, i] + 1e-300)
            if promise > best:
                best, found = promise, i
    return found


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def slide(swept, i, values, free, lower, upper, down):
    """Move along the direction in which the free columns cancel column `i`: the cost falls straight, until a bound.

    Returns False where no bound stops it. Afterwards the variable that met its bound is fixed.
    """
    sign = 1.0 if down[i] > 0 else -1.0
    reach, blocked = (upper[i] - values[i] if sign > 0 else values[i] - lower[i]), i
    for f in range(values.size):
        rate = -sign * swept[i, f]
        if free[f] and rate != 0.0:
            room = (upper[f] - values[f]) / rate if rate > 0 else (lower[f] - values[f]) / rate
            if room < reach:
                reach, blocked = room, f
    if not np.isfinite(reach):
        return False
    rising = sign > 0 if blocked == i else -sign * swept[i, blocked] > 0
    for r in range(values.size):
        if free[r]:
            values[r] -= reach * sign * swept[i, r]
        elif r != i:
            down[r] -= reach * sign * swept[i, r]
    values[i] += reach * sign
    down[i] -= reach * sign * swept[i, i]
    values[blocked] = upper[blocked] if rising else lower[blocked]
    if blocked != i:
        free[blocked] = False
        pivot(swept, blocked, -1.0)
    return True


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def descend(gram, swept, values, free, lower, upper, down, step, threshold, most):
    """Free and fix variables until no slope in `down` exceeds `threshold`, or `most` pivots were made; their number.

    All but `gram`, of which the diagonal alone is read, are in step with one another on entry and on return.
    """
    pivots = 0
    while True:
        pivots += minimise_free(swept, values, free, lower, upper, down, step)
        i = entering(gram, swept, values, free, lower, upper, down, threshold)
        if i < 0 or pivots > most:
            return pivots
        if swept[i, i] <= DEPENDENT * gram[i, i] and not slide(swept, i, values, free, lower, upper, down):
            return pivots
        if swept[i, i] > DEPENDENT * gram[i, i]:
            free[i] = True
            pivot(swept, i, 1.0)
        pivots += 1


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def solve_one(gram, linear, lower, upper, values, free, swept, down, step, tolerance):
    """One frame. `values` feasible and `swept` in step with `free` on entry and on return; (pivots, breach, scale).

    `down` is left holding the slope at the solution; `step` is room to work in.
    """
    k = values.size
    slope(gram, linear, values, down)
    scale = 1e-300
    for i in range(k):
        scale = max(scale, abs(linear[i]), abs(down[i]))
    pivots, breach, most = 0, np.inf, 10 * k + 100
    for attempt in range(REFINEMENTS):
        pivots += descend(gram, swept, values, free, lower, upper, down, step, tolerance * scale, most - pivots)
        slope(gram, linear, values, down)
        breach = violation(down, values, free, lower, upper)
        if breach <= tolerance * scale:
            break
        if attempt % 2 == 1:
            rebuild(gram, free, swept)
        most += k
    return pivots, breach, scale


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def start_at(values, lower, upper, free):
    """Clip `values` into the box and call those strictly inside free."""
    for i in range(values.size):
        values[i] = min(max(values[i], lower[i]), upper[i])
        free[i] = lower[i] < values[i] < upper[i]


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def solve_chunk(first, last, gram, linear, lower, upper, warm, tolerance, values, breach, pivots):
    """Frames `first` to `last`, one after the other, each from the state of the one before; fills the results."""
    k = linear.shape[1]
    w, free, swept = np.zeros(k), np.zeros(k, np.bool_), np.empty((k, k))
    down, step = np.empty(k), np.empty(k)
    start_at(w, lower, upper, free)
    for t in range(first, last):
        own = t if gram.shape[0] > 1 else 0
        if warm.shape[0]:
            for i in range(k):
                w[i] = warm[t, i]
            start_at(w, lower, upper, free)
        if warm.shape[0] or gram.shape[0] > 1 or t == first:
            rebuild(gram[own], free, swept)
        pivots[t], worst, scale = solve_one(gram[own], linear[t], lower, upper, w, free, swept, down, step, tolerance)
        breach[t] = worst / scale
        for i in range(k):
            values[t, i] = w[i]


def boxls(gram, linear, lower, upper, warm, tolerance):
    """min 1/2 w'Gw - b'w, lower <= w <= upper, for every frame.

    gram (1 or t, k, k), linear (t, k), bounds (k,), warm (t, k) or (0, k) for none. Returns values (t, k), the
    largest breach of the optimality conditions relative to the largest slope (t,), pivots (t,).
    """
    frames, k = linear.shape
    values, breach, pivots = np.empty((frames, k)), np.empty(frames), np.empty(frames, np.int64)

    def solve(first, last):
        for chunk in range(first, last):
            ends = chunk * CHUNK, min((chunk + 1) * CHUNK, frames)
            solve_chunk(*ends, gram, linear, lower, upper, warm, tolerance, values, breach, pivots)

    spread(solve, (frames + CHUNK - 1) // CHUNK)
    return values, breach, pivots
