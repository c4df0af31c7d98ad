"""Numpy twin of `polymap`."""

import numpy as np


def _monomials(parameters, exponents):
    """(p, m)."""
    return (parameters[:, None, :] ** exponents[None]).prod(axis=2)


def accumulate(gram, linear, parameters, values, weights, exponents):
    """Add one frame to the normal equations of every texel."""
    powers = _monomials(parameters, exponents)
    seen = weights > 0
    rows, columns = np.triu_indices(len(exponents))
    gram[seen] += (weights[:, None] * powers[:, rows] * powers[:, columns])[seen]
    linear[seen] += (weights[:, None, None] * powers[:, :, None] * values[:, None, :])[seen]


def evaluate(coefficients, parameters, exponents, out):
    """out (p, c): the polynomials at the parameters."""
    out[:] = np.einsum("pm,pmc->pc", _monomials(parameters, exponents), coefficients)


def evaluate_quadratic(coefficients, parameters, out):
    """As `evaluate` for the six terms of eq. 1."""
    evaluate(coefficients, parameters, np.array([[2, 0], [0, 2], [1, 1], [1, 0], [0, 1], [0, 0]]), out)


def parameter_fields(vectors, corners, weights, bases, out):
    """Eq. 3 at every point."""
    out[:] = np.einsum("pcs,pc,psd->pd", vectors[corners], weights, bases)
