"""Numpy twin of `sinusoids`."""

import numpy as np


def search_columns(ratios, precisions, table, steps, windows, best, costs):
    """Each pixel's likeliest entry of the table, narrowed pattern by pattern."""
    patterns, n = table.shape
    for p in range(len(ratios)):
        at = n // 2
        low = np.inf
        for level in range(patterns):
            first, last = max(at - windows[level], 0), min(at + windows[level], n - 1)
            tried = np.arange(first, last + 1, steps[level])
            off = ratios[p, : level + 1, None] - table[: level + 1, tried]
            cost = (precisions[p, : level + 1, None] * off**2).sum(axis=0)
            at, low = tried[np.argmin(cost)], cost.min()
        best[p], costs[p] = at, low


def polish_columns(columns, drifts, ratios, contrasts, precisions, rates, shifts, lags, rounds, sigmas, misfits):
    """Gauss-Newton from `columns`, which are moved."""
    curvature, moved = np.zeros(len(columns)), drifts[:, None] * lags
    for _ in range(rounds):
        angle = (columns[:, None] + moved) * rates + shifts
        slope = -0.5 * contrasts * rates * np.sin(angle)
        off = ratios - (1 + contrasts * np.cos(angle)) / 2
        curvature = (precisions * slope**2).sum(1)
        columns += np.clip((precisions * slope * off).sum(1) / curvature, -1, 1)
    off = ratios - (1 + contrasts * np.cos((columns[:, None] + moved) * rates + shifts)) / 2
    sigmas[:] = 1 / np.sqrt(curvature)
    misfits[:] = (precisions * off**2).sum(1) / max(len(rates) - 1, 1)


def contrast_moments(columns, drifts, ratios, rates, shifts, lags, moments):
    """What is expected times what is seen, and its square."""
    expected = np.cos((columns[:, None] + drifts[:, None] * lags) * rates + shifts)
    moments[..., 0] = expected * (2 * ratios - 1)
    moments[..., 1] = expected**2


def drift_moments(columns, drifts, ratios, contrasts, precisions, rates, shifts, lags, moments):
    """Right and left side of the drift's normal equation, the columns eliminated."""
    angle = (columns[:, None] + drifts[:, None] * lags) * rates + shifts
    slope = -0.5 * contrasts * rates * np.sin(angle)
    off = ratios - (1 + contrasts * np.cos(angle)) / 2
    weight = precisions * slope**2
    lag = lags - ((weight * lags).sum(1) / weight.sum(1))[:, None]
    moments[:, 0] = (precisions * slope * off * lag).sum(1)
    moments[:, 1] = (weight * lag**2).sum(1)
