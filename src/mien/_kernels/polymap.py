"""Polynomial maps of few parameters a texel: accumulating their normal equations, and evaluating them."""

from typing import no_type_check

import numba as nb
import numpy as np

PIECE = 4096
"""Points whose parameters are held in the cache."""


@no_type_check
@nb.njit(cache=True, nogil=True, inline="always")
def _monomials(d, exponents, out):
    """out[m] = d[0]^a d[1]^b ... for every row (a, b, ...) of `exponents`, (m, q)."""
    for m in range(exponents.shape[0]):
        value = 1.0
        for axis in range(exponents.shape[1]):
            for _ in range(exponents[m, axis]):
                value *= d[axis]
        out[m] = value


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def accumulate(gram, linear, count, energy, parameters, values, weights, exponents):
    """Add one frame to the normal equations of every texel.

    gram (p, m (m + 1) / 2), the upper triangle row by row; linear (p, m, c); count (p,) the sum of weights; energy (p,)
    that of squared values; parameters (p, q); values (p, c), NaN where the frame shows nothing; weights (p,), or (1,)
    where all texels weigh the same; exponents (m, q).
    """
    terms = exponents.shape[0]
    powers = np.empty(terms)
    for p in range(gram.shape[0]):
        weight = weights[p % weights.shape[0]]
        square = 0.0
        for c in range(values.shape[1]):
            square += values[p, c] * values[p, c]
        if weight == 0.0 or not square < np.inf:
            continue
        count[p] += weight
        energy[p] += weight * square
        _monomials(parameters[p], exponents, powers)
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
    """out (p, c) = the polynomials of `coefficients` (p, m, c) at `parameters` (p, q)."""
    terms = exponents.shape[0]
    powers = np.empty(terms)
    for p in range(coefficients.shape[0]):
        _monomials(parameters[p], exponents, powers)
        for c in range(coefficients.shape[2]):
            total = 0.0
            for m in range(terms):
                total += powers[m] * coefficients[p, m, c]
            out[p, c] = total


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def parameter_fields(forms, triangle, weights, out):
    """Eq. 3 at every point: out (p, 2) = the forms (m, 2, 6) of each point's `triangle` (p,) at its `weights` (2, p).

    A form's entries are the coefficients of aa, bb, cc, ab, ac, bc, with c = 1 - a - b.
    """
    for p in range(triangle.shape[0]):
        a, b = weights[0, p], weights[1, p]
        c = np.float32(1) - a - b
        for d in range(2):
            f = forms[triangle[p], d]
            out[p, d] = a * (f[0] * a + f[3] * b + f[4] * c) + b * (f[1] * b + f[5] * c) + f[2] * c * c


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def _evaluate_plane(d1, d2, k0, k1, k2, k3, k4, k5, least, greatest, out):
    """One channel of eq. 1 over points that lie side by side."""
    for p in range(out.shape[0]):
        free = (k0[p] * d1[p] + k2[p] * d2[p] + k3[p]) * d1[p] + (k1[p] * d2[p] + k4[p]) * d2[p] + k5[p]
        out[p] = min(max(free, least[p]), greatest[p])


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def _form_at(f0, f1, f2, f3, f4, f5, a, b, out):
    """A triangle's form at weights that lie side by side."""
    for p in range(out.shape[0]):
        c = np.float32(1) - a[p] - b[p]
        out[p] = a[p] * (f0 * a[p] + f3 * b[p] + f4 * c) + b[p] * (f1 * b[p] + f5 * c) + f2 * c * c


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def evaluate_runs(forms, runs, triangle, weights, planes, out):
    """`parameter_fields` and the six terms of eq. 1 in one go: the loop that a live synthesis spends its time in.

    runs (r + 1,): points between two entries lie in one triangle; planes (c, 8, p): the coefficients, and the least and
    greatest that comes of them; out (c, p). Parameters of a piece of the list stay in the cache until they come by.
    """
    points, r = out.shape[1], 0
    d = np.empty((2, PIECE), np.float32)
    for first in range(0, points, PIECE):
        last = min(first + PIECE, points)
        start = first
        while start < last:
            while runs[r + 1] <= start:
                r += 1
            stop = min(runs[r + 1], last)
            for axis in range(2):
                f = forms[triangle[start], axis]
                _form_at(f[0], f[1], f[2], f[3], f[4], f[5], weights[0, start:stop], weights[1, start:stop],
                         d[axis, start - first : stop - first])  # fmt: skip
            start = stop
        n = last - first
        for c in range(out.shape[0]):
            k = planes[c]
            _evaluate_plane(d[0, :n], d[1, :n], k[0, first:last], k[1, first:last], k[2, first:last],
                            k[3, first:last], k[4, first:last], k[5, first:last], k[6, first:last],
                            k[7, first:last], out[c, first:last])  # fmt: skip
