"""Greedy selection of frames: what each candidate would take off the error, exactly, given up as early as may be."""

from typing import no_type_check

import numba as nb
import numpy as np

from ._spread import spread
from .boxls import DEPENDENT, MATHS, add, descend, rebuild, solve_one

LANES = 16
"""Candidates that one thread weighs together, frame by frame."""

STRETCH = 64
"""Frames after which hopeless candidates are dropped."""

TOLERANCE = 1e-12
"""Relative breach of the optimality conditions that the weights are solved to."""


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def restate_frames(first, last, gram, linear, weights, slack, free, swept):
    """Solve frames `first` to `last` from the weights they have; in place."""
    k = gram.shape[0]
    lower, upper, down, step = np.zeros(k), np.empty(k), np.empty(k), np.empty(k)
    for i in range(k):
        upper[i] = np.inf
    for t in range(first, last):
        for i in range(k):
            free[t, i] = weights[t, i] > 0
        rebuild(gram, free[t], swept[t])
        solve_one(gram, linear[t], lower, upper, weights[t], free[t], swept[t], down, step, TOLERANCE)
        for i in range(k):
            slack[t, i] = weights[t, i] if free[t, i] else max(-down[i], 0.0)


def restate(gram, linear, weights):
    """Non-negative least squares of every frame, from `weights` (t, k) on: gram (k, k), linear (t, k).

    Returns the weights, slack (t, k) (the weight where it is free, minus the slope where it is 0), free (t, k) and the
    swept tableaux (t, k, k).
    """
    frames, k = linear.shape
    weights, slack = weights.copy(), np.empty((frames, k))
    free, swept = np.empty((frames, k), np.bool_), np.empty((frames, k, k))
    spread(lambda a, b: restate_frames(a, b, gram, linear, weights, slack, free, swept), frames)
    return weights, slack, free, swept


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def column_of(heights, own, swept, free, column):
    """Fill `column` (k,), what a candidate would have in one frame's tableau; its squared length outside the free ones.

    heights (k,) are the candidate's inner products with the frames chosen so far, own with itself.
    """
    for i in range(free.size):
        column[i] = 0.0
    for f in range(free.size):
        if free[f]:
            add(column, -heights[f], swept[f])
    height = own
    for i in range(free.size):
        if free[i]:
            height -= column[i] * heights[i]
        else:
            column[i] += heights[i]
    return height


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def one_step(g, heights, own, apart, error, slack, swept, free, column):
    """(Gain of one candidate in one frame, whether one step gives it exactly); a bound where it does not. g > 0."""
    loose = min(g * g / apart, error) if apart > 0.0 else error
    height = column_of(heights, own, swept, free, column)
    if height <= DEPENDENT * own:
        return loose, False
    step = g / height
    crossed, turned = False, False
    for i in range(slack.size):
        if free[i]:
            crossed |= slack[i] < step * column[i]
        else:
            turned |= slack[i] < -step * column[i]
    if turned:
        return loose, False
    return min(g * step, loose), not crossed


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def full_gain(g, heights, own, scale, weights, slack, swept, free, whole, column, vectors, loose, tableau):
    """What one candidate takes off one frame's squared error: active set from the frame's own solution on.

    whole (k + 1, k + 1) is the Gram matrix with the candidate, scale the largest slope there can be; vectors
    (5, k + 1), loose and tableau are room to work in, vectors[0] holding zeros and vectors[1] infinity.
    """
    k = weights.size
    w, down = vectors[2], vectors[3]
    w[k], down[k], loose[k] = 0.0, g, False
    tableau[k, k] = column_of(heights, own, swept, free, column)
    for i in range(k):
        w[i], down[i], loose[i] = weights[i], (0.0 if free[i] else -slack[i]), free[i]
        tableau[k, i] = tableau[i, k] = column[i]
        for j in range(k):
            tableau[i, j] = swept[i, j]
    descend(whole, tableau, w, loose, vectors[0], vectors[1], down, vectors[4], TOLERANCE * scale, 10 * k + 100)
    gain = w[k] * (g + down[k])
    for i in range(k):
        gain += (w[i] - weights[i]) * (down[i] - (0.0 if free[i] else slack[i]))
    return gain


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def border(gram, heights, own, whole):
    """whole = gram with a candidate's row and column added."""
    k = gram.shape[0]
    for i in range(k):
        for j in range(k):
            whole[i, j] = gram[i, j]
        whole[i, k] = whole[k, i] = heights[i]
    whole[k, k] = own


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS | {"nnan"}, error_model="numpy")
def ceiling(products, apart, errors):
    """(bound of one candidate's gain, sum of its squared positive products)."""
    total, squares = 0.0, 0.0
    scale = 1.0 / apart if apart > 0.0 else 1e300
    for t in range(products.size):
        g = max(products[t], 0.0)
        squares += g * g
        total += min(g * g * scale, errors[t])
    return total, squares


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def through_chosen(inner, heights, mixes, out):
    """out (t,) = inner - heights . mixes: one candidate's products with all residuals."""
    for t in range(out.size):
        out[t] = inner[t]
    for i in range(heights.size):
        add(out, -heights[i], mixes[i])


@no_type_check
@nb.njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def residual_products(inner, heights, mixes, candidates):
    """Products of candidates (c,) with all residuals, (c, t).

    inner (t, t): products of all frames; heights (t, k): of all with the chosen ones; mixes (k, t): the weights.
    """
    out = np.empty((len(candidates), inner.shape[1]))
    for c in nb.prange(len(candidates)):
        through_chosen(inner[candidates[c]], heights[candidates[c]], mixes, out[c])
    return out


@no_type_check
@nb.njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def ceilings(products, apart, errors):
    """For every candidate (c,) the bound of its gain, and the sum of its squared positive products (c, t)."""
    bounds, squares = np.empty(len(products)), np.empty(len(products))
    for c in nb.prange(len(products)):
        bounds[c], squares[c] = ceiling(products[c], apart[c], errors)
    return bounds, squares


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def first_look(products, heights, own, apart, order, errors, slack, free, swept, best, total, left):
    """Bounds of the gains of a block of candidates, total (c,), and of what one step leaves open, left (c, t)."""
    count, frames = products.shape
    column, alive = np.empty(heights.shape[1]), np.empty(count, np.bool_)
    for c in range(count):
        total[c] = ceiling(products[c], apart[c], errors)[0]
    for first in range(0, frames, STRETCH):
        for c in range(count):
            alive[c] = total[c] >= best
        for place in range(first, min(first + STRETCH, frames)):
            t = order[place]
            for c in range(count):
                g = products[c, t]
                if alive[c] and g > 0.0:
                    loose = min(g * g / apart[c], errors[t]) if apart[c] > 0.0 else errors[t]
                    gain, exact = one_step(
                        g, heights[c], own[c], apart[c], errors[t], slack[t], swept[t], free[t], column
                    )
                    total[c] += gain - loose
                    left[c, t] = 0.0 if exact else gain


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def sink(keys, heap, at, size):
    """Let entry `at` of a heap of places in `keys`, the largest first, down to where it belongs."""
    moved = heap[at]
    child = 2 * at + 1
    while child < size:
        if child + 1 < size and keys[heap[child + 1]] > keys[heap[child]]:
            child += 1
        if keys[heap[child]] <= keys[moved]:
            break
        heap[at] = heap[child]
        at, child = child, 2 * child + 1
    heap[at] = moved


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def heap_of(keys, heap):
    """Fill `heap` with the places of the positive `keys`, the largest first; how many they are."""
    size = 0
    for t in range(keys.size):
        if keys[t] > 0.0:
            heap[size] = t
            size += 1
    for at in range(size // 2 - 1, -1, -1):
        sink(keys, heap, at, size)
    return size


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def weigh_block(products, heights, own, apart, order, errors, scale, gram, weights, slack, free, swept, best, total):
    """Fill total (c,), the gains of one block of candidates; -1 where a bound shows that `best` is not reached."""
    k, count = gram.shape[0], len(products)
    left = np.zeros(products.shape)
    first_look(products, heights, own, apart, order, errors, slack, free, swept, best, total, left)
    whole, tableau, vectors = np.empty((k + 1, k + 1)), np.empty((k + 1, k + 1)), np.zeros((5, k + 1))
    for i in range(k + 1):
        vectors[1, i] = np.inf
    loose, column, heap = np.empty(k + 1, np.bool_), np.empty(k), np.empty(left.shape[1], np.int64)
    for c in range(count):
        border(gram, heights[c], own[c], whole)
        size = heap_of(left[c], heap) if total[c] >= best else 0
        while size > 0 and total[c] >= best:
            t = heap[0]
            size -= 1
            heap[0] = heap[size]
            sink(left[c], heap, 0, size)
            total[c] -= left[c, t]
            total[c] += full_gain(
                products[c, t], heights[c], own[c], scale, weights[t], slack[t], swept[t], free[t],
                whole, column, vectors, loose, tableau,
            )  # fmt: skip
        if total[c] >= best:
            best = total[c]
        else:
            total[c] = -1.0


def weigh(products, heights, own, apart, order, errors, scale, gram, weights, slack, free, swept, best):
    """What each candidate would take off the summed squared error, or -1 where that is less than `best`.

    products (c, t): candidate . residual; heights (c, k): candidate . chosen frame; own and apart (c,): squared lengths
    of the candidates and of their part outside the span of the chosen ones; order (t,): frames, those with most to gain
    first; errors (t,): squared residuals; scale: largest squared length of a frame; the rest as `restate` gives it.
    """
    gains = np.empty(len(products))

    def weigh_lanes(first_lane, last_lane):
        for lane in range(first_lane, last_lane):
            some = slice(lane * LANES, (lane + 1) * LANES)
            weigh_block(
                products[some], heights[some], own[some], apart[some], order, errors, scale, gram, weights,
                slack, free, swept, best, gains[some],
            )  # fmt: skip

    spread(weigh_lanes, (len(products) + LANES - 1) // LANES)
    return gains
