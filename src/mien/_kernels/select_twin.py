"""Numpy twins of `select`: every frame and every candidate solved anew."""

import numpy as np

from .boxls_twin import boxls


def restate(gram, linear, weights):
    """Weights, slack, free and swept tableaux of every frame; arguments and results as the kernel's."""
    k = len(gram)
    values = boxls(gram[None], linear, np.zeros(k), np.full(k, np.inf), weights, 1e-12)[0]
    free = values > 0
    slack = np.where(free, values, values @ gram - linear)
    swept = np.array([_swept(gram, f) for f in free])
    return values, slack, free, swept


def weigh(rows, basis, tried):
    """What each of `tried` (c, d), added to `basis` (k, d), takes off the summed squared error of `rows` (t, d)."""
    before = _errors(rows, basis).sum()
    return np.array([before - _errors(rows, np.vstack([basis, one])).sum() for one in tried])


def _swept(gram, free):
    swept = np.empty(gram.shape)
    inverse = np.linalg.inv(gram[np.ix_(free, free)])
    across = inverse @ gram[np.ix_(free, ~free)]
    swept[np.ix_(free, free)] = -inverse
    swept[np.ix_(free, ~free)], swept[np.ix_(~free, free)] = across, across.T
    swept[np.ix_(~free, ~free)] = gram[np.ix_(~free, ~free)] - gram[np.ix_(~free, free)] @ across
    return swept


def _errors(rows, basis):
    k = len(basis)
    start = np.zeros((0, k))
    values = boxls((basis @ basis.T)[None], rows @ basis.T, np.zeros(k), np.full(k, np.inf), start, 1e-12)[0]
    return ((rows - values @ basis) ** 2).sum(axis=1)
