"""Values of scattered pixels summed over blocks of a picture, and read back between the blocks."""

from typing import no_type_check

import numba as nb


@no_type_check
@nb.njit(cache=True, nogil=True)
def sum_blocks(values, rows, columns, step, sums):
    """Add values (p, c) at pixels rows, columns (p,) to the blocks of step x step pixels that they lie in: sums
    (h, w, c)."""
    for p in range(values.shape[0]):
        for c in range(values.shape[1]):
            sums[rows[p] // step, columns[p] // step, c] += values[p, c]


@no_type_check
@nb.njit(cache=True, nogil=True)
def read_blocks(blocks, rows, columns, step, out):
    """Bilinear between the centres of blocks (h, w, c), at pixels rows, columns (p,): out (p, c) is written."""
    height, width = blocks.shape[:2]
    for p in range(rows.shape[0]):
        y = min(max((rows[p] + 0.5) / step - 0.5, 0.0), height - 1.0)
        x = min(max((columns[p] + 0.5) / step - 0.5, 0.0), width - 1.0)
        i, j = min(int(y), max(height - 2, 0)), min(int(x), max(width - 2, 0))
        below, right = min(i + 1, height - 1), min(j + 1, width - 1)
        v, u = y - i, x - j
        for c in range(blocks.shape[2]):
            upper = (1.0 - u) * blocks[i, j, c] + u * blocks[i, right, c]
            lower = (1.0 - u) * blocks[below, j, c] + u * blocks[below, right, c]
            out[p, c] = (1.0 - v) * upper + v * lower
