"""Numpy twin of `polymap`."""

import numpy as np


def _monomials(parameters, exponents):
    """(p, m)."""
    return (parameters[:, None, :] ** exponents[None]).prod(axis=2)


def accumulate(gram, linear, count, energy, parameters, values, weights, exponents):
    """Add one frame to the normal equations of every texel."""
    powers = _monomials(parameters, exponents)
    weights = np.broadcast_to(weights, len(values))
    seen = (weights > 0) & np.isfinite(values).all(axis=1)
    count[seen] += weights[seen]
    energy[seen] += (weights[:, None] * values**2).sum(axis=1)[seen]
    rows, columns = np.triu_indices(len(exponents))
    gram[seen] += (weights[:, None] * powers[:, rows] * powers[:, columns])[seen]
    linear[seen] += (weights[:, None, None] * powers[:, :, None] * values[:, None, :])[seen]


def evaluate(coefficients, parameters, exponents, out):
    """out (p, c): the polynomials at the parameters."""
    out[:] = np.einsum("pm,pmc->pc", _monomials(parameters, exponents), coefficients)


def parameter_fields(forms, triangle, weights, out):
    """Eq. 3 at every point."""
    a, b = weights
    c = 1 - a - b
    out[:] = np.einsum("pdf,fp->pd", forms[triangle], np.stack([a * a, b * b, c * c, a * b, a * c, b * c]))


def evaluate_runs(forms, runs, triangle, weights, planes, out):
    """`parameter_fields`, then the six terms of eq. 1, held between the last two planes."""
    d = np.empty((len(triangle), 2), np.float32)
    parameter_fields(forms, triangle, weights, d)
    found = np.empty(out.T.shape, np.float32)
    evaluate(planes[:, :6].transpose(2, 1, 0), d, np.array([[2, 0], [0, 2], [1, 1], [1, 0], [0, 1], [0, 0]]), found)
    out[:] = np.clip(found.T, planes[:, 6], planes[:, 7])
