"""Sums over a tall stack of rows, in one thread: a live loop cannot wait for the threads of a BLAS to gather."""

from typing import no_type_check

import numba as nb
import numpy as np

BLOCK = 512
"""Entries of a row that stay in the first-level cache while all rows are added up."""


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"}, error_model="numpy")
def inner(a, b):
    """a' b of two rows of one type, in that type. By whole rows: an offset into a longer one is not vectorised."""
    total = a.dtype.type(0)
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def products(rows, row):
    """Inner products (s,) of rows (s, n) with row (n,), of one type; summed in float64 every `BLOCK` entries."""
    count, length = rows.shape
    out = np.zeros(count)
    for s in range(count):
        for first in range(0, length, BLOCK):
            out[s] += inner(rows[s, first : first + BLOCK], row[first : first + BLOCK])
    return out


@no_type_check
@nb.njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"}, error_model="numpy")
def add_four(line, a, b, c, d, row_a, row_b, row_c, row_d):
    """line += a row_a + b row_b + c row_c + d row_d."""
    for i in range(line.size):
        line[i] += a * row_a[i] + b * row_b[i] + c * row_c[i] + d * row_d[i]


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def combine(rows, mix):
    """mix' rows, (k, n), of rows (s, n) and mix (s, k) of the same type; each row is read from memory once."""
    count, length = rows.shape
    out = np.zeros((mix.shape[1], length), rows.dtype)
    none = np.zeros(BLOCK, rows.dtype)
    for first in range(0, length, BLOCK):
        last = min(first + BLOCK, length)
        for s in range(0, count, 4):
            b = rows[s + 1, first:last] if s + 1 < count else none[: last - first]
            c = rows[s + 2, first:last] if s + 2 < count else none[: last - first]
            d = rows[s + 3, first:last] if s + 3 < count else none[: last - first]
            for j in range(mix.shape[1]):
                m = mix[s : s + 4, j]
                m1, m2, m3 = m[min(1, m.size - 1)], m[min(2, m.size - 1)], m[min(3, m.size - 1)]
                add_four(out[j, first:last], m[0], m1, m2, m3, rows[s, first:last], b, c, d)
    return out
