"""Polynomial maps of two parameters a texel: accumulating their normal equations, and evaluating them."""

from typing import no_type_check

import numba as nb
import numpy as np


@no_type_check
@nb.njit(cache=True, nogil=True, inline="always")
def _monomials(d1, d2, exponents, out):
    """out[m] = d1^a d2^b for every row (a, b) of `exponents`, (m, 2)."""
    for m in range(exponents.shape[0]):
        value = 1.0
        for _ in range(exponents[m, 0]):
            value *= d1
        for _ in range(exponents[m, 1]):
            value *= d2
        out[m] = value


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def accumulate(gram, linear, parameters, values, weights, exponents):
    """Add one frame to the normal equations of every texel.

    gram (p, m (m + 1) / 2), the upper triangle row by row; linear (p, m, c); parameters (p, 2); values (p, c);
    weights (p,), 0 where the frame shows nothing; exponents (m, 2).
    """
    terms = exponents.shape[0]
    powers = np.empty(terms)
    for p in range(gram.shape[0]):
        weight = weights[p]
        if weight == 0.0:
            continue
        _monomials(parameters[p, 0], parameters[p, 1], exponents, powers)
        place = 0
        for i in range(terms):
            scaled = weight * powers[i]
            for j in range(i, terms):
                gram[p, place] += scaled * powers[j]
                place += 1
            for c in range(values.shape[1]):
                linear[p, i, c] += scaled * values[p, c]


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def evaluate(coefficients, parameters, exponents, out):
    """out (p, c) = the polynomials of `coefficients` (p, m, c) at `parameters` (p, 2)."""
    terms = exponents.shape[0]
    powers = np.empty(terms)
    for p in range(coefficients.shape[0]):
        _monomials(parameters[p, 0], parameters[p, 1], exponents, powers)
        for c in range(coefficients.shape[2]):
            total = 0.0
            for m in range(terms):
                total += powers[m] * coefficients[p, m, c]
            out[p, c] = total


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def evaluate_quadratic(coefficients, parameters, out):
    """As `evaluate` for the six terms of eq. 1 in their order: the loop that a live synthesis spends its time in."""
    for p in range(coefficients.shape[0]):
        d1 = parameters[p, 0]
        d2 = parameters[p, 1]
        for c in range(coefficients.shape[2]):
            out[p, c] = (
                (coefficients[p, 0, c] * d1 + coefficients[p, 2, c] * d2 + coefficients[p, 3, c]) * d1
                + (coefficients[p, 1, c] * d2 + coefficients[p, 4, c]) * d2
                + coefficients[p, 5, c]
            )


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def parameter_fields(vectors, corners, weights, bases, out):
    """Eq. 3 at every point: out (p, 2) = the deformation vectors, interpolated, times the bases, interpolated.

    vectors (k, s) at the markers; corners (p, 3) the markers round each point; weights (p, 3); bases (p, s, 2).
    """
    size = vectors.shape[1]
    for p in range(corners.shape[0]):
        first = second = 0.0
        a, b, c = corners[p, 0], corners[p, 1], corners[p, 2]
        wa, wb, wc = weights[p, 0], weights[p, 1], weights[p, 2]
        for s in range(size):
            value = wa * vectors[a, s] + wb * vectors[b, s] + wc * vectors[c, s]
            first += value * bases[p, s, 0]
            second += value * bases[p, s, 1]
        out[p, 0] = first
        out[p, 1] = second
