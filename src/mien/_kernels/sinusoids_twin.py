"""Numpy twin of `sinusoids`."""

import numpy as np


def search_columns(ratios, precisions, tables, steps, windows, best):
    """Each pixel's likeliest entry of the tables, narrowed pattern by pattern."""
    levels, _, n = tables.shape
    for p in range(len(ratios)):
        at = windows[0]
        for level, step, window in zip(range(levels), steps, windows, strict=True):
            tried = np.arange(max(-((window - at) // step), 0), min((at + window) // step, n - 1) + 1)
            off = ratios[p, : level + 1, None] - tables[level, : level + 1, tried].T
            at = tried[np.argmin((precisions[p, : level + 1, None] * off**2).sum(axis=0))] * step
        best[p] = at


def polish_columns(columns, drifts, ratios, contrasts, precisions, rates, shifts, lags, rounds, sigmas, misfits):
    """Gauss-Newton from `columns`, which are moved."""
    curvature, total, moved = np.zeros(len(columns)), np.zeros(len(columns)), drifts[:, None] * lags
    for _ in range(rounds):
        angle = (columns[:, None] + moved) * rates + shifts
        slope = -0.5 * contrasts * rates * np.sin(angle)
        off = ratios - (1 + contrasts * np.cos(angle)) / 2
        curvature = (precisions * slope**2).sum(1)
        gradient = (precisions * slope * off).sum(1)
        step = np.clip(gradient / curvature, -1, 1)
        columns += step
        total = (precisions * (off - slope * step[:, None]) ** 2).sum(1)
    sigmas[:] = 1 / np.sqrt(curvature)
    misfits[:] = total / max(len(rates) - 1, 1)


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
