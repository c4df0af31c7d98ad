"""Projector columns from folded sinusoids: maximum likelihood on a table of the patterns, coarse to fine."""

from typing import no_type_check

import numba as nb
import numpy as np

TURN = 2.0 * np.pi
C0, C1, C2, C3 = 0.9999999998855528, -19.73920874345372, 64.93938907588553, -85.4566583146736
C4, C5, C6, C7 = 60.24213133734386, -26.404668182882958, 7.800131427078988, -1.4531123056430946
"""Powers of t^2 in cos(2 pi t), |t| <= 1/2: a Chebyshev fit, off by 1e-10 at most."""
S0, S1, S2, S3 = 6.283185307136663, -41.341702218380625, 81.60524742184047, -76.70580021899372
S4, S5, S6, S7 = 42.057754016921, -15.086565254015207, 3.7813188595600944, -0.6207786922712774
"""Likewise in sin(2 pi t) / t."""


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"}, inline="always")
def cosine_and_sine(angle):
    """Of an angle, radians, to 1e-10: three times as fast as the library's, which are exact for any."""
    t = angle / TURN
    t -= np.floor(t + 0.5)
    z = t * t
    cosine = C0 + z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * (C6 + z * C7))))))
    sine = t * (S0 + z * (S1 + z * (S2 + z * (S3 + z * (S4 + z * (S5 + z * (S6 + z * S7)))))))
    return cosine, sine


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def search_columns(ratios, precisions, tables, steps, windows, best):
    """Each pixel's likeliest entry of the tables, narrowed pattern by pattern.

    ratios, precisions (p, k), 1 / variance; tables (k, k, n), 32-bit as is the search: for each level the patterns,
    coarse to fine, at its even columns, `steps` (k,) of the finest's apart; windows (k,): how far round the last
    estimate level k tries, likewise in the finest's; best (p,) is written, in the finest's too. Level k goes by
    patterns 0 to k.
    """
    levels, _, n = tables.shape
    costs = np.empty(n, tables.dtype)
    for p in range(ratios.shape[0]):
        at = windows[0]
        for level in range(levels):
            step = steps[level]
            first = max((at - windows[level] + step - 1) // step, 0)
            last = min((at + windows[level]) // step, n - 1)
            count = last - first + 1
            costs[:count] = 0.0
            for k in range(level + 1):
                ratio, precision = ratios[p, k], precisions[p, k]
                for i in range(count):
                    off = ratio - tables[level, k, first + i]
                    costs[i] += precision * off * off
            likeliest = 0
            for i in range(1, count):
                if costs[i] < costs[likeliest]:
                    likeliest = i
            at = (first + likeliest) * step
        best[p] = at


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def polish_columns(columns, drifts, ratios, contrasts, precisions, rates, shifts, lags, rounds, sigmas, misfits):
    """Gauss-Newton from `columns` (p,), which are moved, on `ratios = (1 + contrast cos(angle)) / 2` with
    angle = (column + drift lag) rate + shift.

    ratios, contrasts, precisions (p, k); drifts (p,), columns a slot; lags (k,), slots; rates, shifts (k,), radians;
    sigmas, misfits (p,) are written: the standard deviation, and the mean squared residual in variances, as the last
    round's straight lines have it.
    """
    patterns = rates.shape[0]
    for p in range(columns.shape[0]):
        u = columns[p]
        curvature, total = 0.0, 0.0
        for _ in range(rounds):
            gradient, curvature, total = 0.0, 0.0, 0.0
            for k in range(patterns):
                cosine, sine = cosine_and_sine((u + drifts[p] * lags[k]) * rates[k] + shifts[k])
                slope = -0.5 * contrasts[p, k] * rates[k] * sine
                off = ratios[p, k] - (1.0 + contrasts[p, k] * cosine) / 2.0
                gradient += precisions[p, k] * slope * off
                curvature += precisions[p, k] * slope * slope
                total += precisions[p, k] * off * off
            step = min(max(gradient / curvature, -1.0), 1.0)
            u += step
            total += step * (step * curvature - 2.0 * gradient)
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
            expected, _ = cosine_and_sine((columns[p] + drifts[p] * lags[k]) * rates[k] + shifts[k])
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
            cosine, sine = cosine_and_sine((columns[p] + drifts[p] * lags[k]) * rates[k] + shifts[k])
            slope = -0.5 * contrasts[p, k] * rates[k] * sine
            off = ratios[p, k] - (1.0 + contrasts[p, k] * cosine) / 2.0
            w = precisions[p, k] * slope * slope
            weight += w
            first += w * lags[k]
            second += w * lags[k] * lags[k]
            pull += precisions[p, k] * slope * off
            pulled += precisions[p, k] * slope * off * lags[k]
        moments[p, 0] = pulled - pull * first / weight
        moments[p, 1] = second - first * first / weight
