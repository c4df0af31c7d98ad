"""Projector columns from folded sinusoids: maximum likelihood on a table of the patterns, coarse to fine."""

from typing import no_type_check

import numba as nb
import numpy as np


@no_type_check
@nb.njit(cache=True, nogil=True, inline="always")
def _cost(ratio, precision, table, j, patterns):
    total = 0.0
    for k in range(patterns):
        off = ratio[k] - table[k, j]
        total += precision[k] * off * off
    return total


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def search_columns(ratios, precisions, table, steps, windows, best, costs):
    """Each pixel's likeliest entry of the table, narrowed pattern by pattern.

    ratios, precisions (p, k), 1 / variance; table (k, n): the patterns at even columns, coarse to fine; steps (k,),
    windows (k,): how far apart and how far round the last estimate the entries lie that level k tries; best (p,) and
    costs (p,) are written: the entry, and half of minus the log likelihood there by all patterns.
    """
    patterns, n = table.shape
    for p in range(ratios.shape[0]):
        at = n // 2
        low = np.inf
        for level in range(patterns):
            low = np.inf
            centre = at
            first = max(centre - windows[level], 0)
            last = min(centre + windows[level], n - 1)
            j = first
            while j <= last:
                cost = _cost(ratios[p], precisions[p], table, j, level + 1)
                if cost < low:
                    low = cost
                    at = j
                j += steps[level]
        best[p] = at
        costs[p] = low


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def polish_columns(columns, drifts, ratios, contrasts, precisions, rates, shifts, lags, rounds, sigmas, misfits):
    """Gauss-Newton from `columns` (p,), which are moved, on `ratios = (1 + contrast cos(angle)) / 2` with
    angle = (column + drift lag) rate + shift.

    ratios, contrasts, precisions (p, k); drifts (p,), columns a slot; lags (k,), slots; rates, shifts (k,), radians;
    sigmas, misfits (p,) are written: the standard deviation, and the mean squared residual in variances.
    """
    patterns = rates.shape[0]
    for p in range(columns.shape[0]):
        u = columns[p]
        curvature = 0.0
        for _ in range(rounds):
            gradient, curvature = 0.0, 0.0
            for k in range(patterns):
                angle = (u + drifts[p] * lags[k]) * rates[k] + shifts[k]
                slope = -0.5 * contrasts[p, k] * rates[k] * np.sin(angle)
                off = ratios[p, k] - (1.0 + contrasts[p, k] * np.cos(angle)) / 2.0
                gradient += precisions[p, k] * slope * off
                curvature += precisions[p, k] * slope * slope
            u += min(max(gradient / curvature, -1.0), 1.0)
        total = 0.0
        for k in range(patterns):
            angle = (u + drifts[p] * lags[k]) * rates[k] + shifts[k]
            off = ratios[p, k] - (1.0 + contrasts[p, k] * np.cos(angle)) / 2.0
            total += precisions[p, k] * off * off
        columns[p] = u
        sigmas[p] = 1.0 / np.sqrt(curvature)
        misfits[p] = total / max(patterns - 1, 1)


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def contrast_moments(columns, drifts, ratios, rates, shifts, lags, moments):
    """For the regression of what is seen on what is expected: moments (p, k, 2) are written, cos(angle) times
    2 ratio - 1, and its square; shapes as in `polish_columns`."""
    for p in range(columns.shape[0]):
        for k in range(rates.shape[0]):
            expected = np.cos((columns[p] + drifts[p] * lags[k]) * rates[k] + shifts[k])
            moments[p, k, 0] = expected * (2.0 * ratios[p, k] - 1.0)
            moments[p, k, 1] = expected * expected


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def drift_moments(columns, drifts, ratios, contrasts, precisions, rates, shifts, lags, moments):
    """Each pixel's part in the normal equation of a drift, its column eliminated: moments (p, 2) are written, right
    side and left; shapes as in `polish_columns`."""
    patterns = rates.shape[0]
    for p in range(columns.shape[0]):
        weight, first, second, pull, pulled = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(patterns):
            angle = (columns[p] + drifts[p] * lags[k]) * rates[k] + shifts[k]
            slope = -0.5 * contrasts[p, k] * rates[k] * np.sin(angle)
            off = ratios[p, k] - (1.0 + contrasts[p, k] * np.cos(angle)) / 2.0
            w = precisions[p, k] * slope * slope
            weight += w
            first += w * lags[k]
            second += w * lags[k] * lags[k]
            pull += precisions[p, k] * slope * off
            pulled += precisions[p, k] * slope * off * lags[k]
        moments[p, 0] = pulled - pull * first / weight
        moments[p, 1] = second - first * first / weight
