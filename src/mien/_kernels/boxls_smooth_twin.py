"""Numpy twin of `boxls_smooth`."""

import numpy as np


def smooth_slope(gram, linear, links, values):
    """linear - H values; arguments and result as the kernel's."""
    curve = np.einsum("tij,tj->ti", np.broadcast_to(gram, (len(linear), *gram.shape[1:])), values)
    curve = curve + links[0][:, None] * values
    for d in (1, 2):
        curve[:-d] += links[d, :-d, None] * values[d:]
        curve[d:] += links[d, :-d, None] * values[:-d]
    return linear - curve


def smooth_band(gram, links, free, order, width, ridge):
    """The band by way of the whole dense matrix; arguments and result as the kernel's."""
    frames, k = free.shape
    whole = np.zeros((frames, k, frames, k))
    for t in range(frames):
        whole[t, :, t] = gram[t % len(gram)]
        for d in range(min(3, frames - t)):
            whole[t, range(k), t + d, range(k)] += links[d, t]
    flat = whole.reshape(frames * k, frames * k)[np.ix_(free.ravel(), free.ravel())]
    flat = np.triu(flat) + ridge * np.eye(len(flat))
    band = np.zeros((len(flat), width + 1))
    for d in range(min(width + 1, len(flat))):
        band[: len(flat) - d, d] = np.diagonal(flat, d)
    return band
