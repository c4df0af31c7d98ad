"""The pieces of the box-constrained solve that is smooth in time: slope of the cost, banded Newton matrix."""

from typing import no_type_check

import numba as nb
import numpy as np

from .boxls import MATHS


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def frame_slope(gram, target, links, values, t, out):
    """Fill out (k,), the slope of frame `t`."""
    frames, k = values.shape
    for i in range(k):
        total = links[0, t] * values[t, i]
        for j in range(k):
            total += gram[i, j] * values[t, j]
        for d in range(1, 3):
            if t + d < frames:
                total += links[d, t] * values[t + d, i]
            if t >= d:
                total += links[d, t - d] * values[t - d, i]
        out[i] = target[i] - total


@no_type_check
@nb.njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def smooth_slope(gram, linear, links, values):
    """linear - H values, (t, k), where H has gram (1 or t, k, k) on its diagonal and links (3, t) in time.

    links[d, t] couples frames t and t + d, the same for every variable.
    """
    down = np.empty(linear.shape)
    for t in nb.prange(len(linear)):
        frame_slope(gram[np.int64(t) % len(gram)], linear[t], links, values, np.int64(t), down[t])
    return down


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def frame_band(gram, links, free, order, ridge, t, band):
    """Fill the rows of frame `t`'s free variables."""
    frames, k = free.shape
    for i in range(k):
        if free[t, i]:
            line = band[order[t, i]]
            for j in range(i, k):
                if free[t, j]:
                    line[order[t, j] - order[t, i]] = gram[j, i]
            line[0] += links[0, t] + ridge
            for d in range(1, 3):
                if t + d < frames and links[d, t] != 0.0 and free[t + d, i]:
                    line[order[t + d, i] - order[t, i]] += links[d, t]


@no_type_check
@nb.njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def smooth_band(gram, links, free, order, width, ridge):
    """Lower band (n, width + 1) of H over the n free variables, LAPACK's layout transposed.

    `free` (t, k); `order` (t, k) numbers the free variables frame by frame; `ridge` is added to the diagonal.
    """
    band = np.zeros((order[-1, -1] + np.int64(free[-1, -1]), width + 1))
    for t in nb.prange(len(free)):
        frame_band(gram[np.int64(t) % len(gram)], links, free, order, ridge, np.int64(t), band)
    return band
