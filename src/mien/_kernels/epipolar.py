"""Along the rows of a rectified pair: where the right picture shows the left one's projector column."""

from typing import no_type_check

import numba as nb
import numpy as np

BLOCK = 16
"""Places of a row whose range of columns is looked at before they are."""


@no_type_check
@nb.njit(cache=True, nogil=True)
def _row_ranges(row, lows, highs):
    """Least and greatest known value of each block and the place behind it."""
    for block in range(lows.shape[0]):
        lows[block], highs[block] = np.inf, -np.inf
        for place in range(block * BLOCK, min((block + 1) * BLOCK + 1, row.shape[0])):
            if np.isfinite(row[place]):
                lows[block] = min(lows[block], row[place])
                highs[block] = max(highs[block], row[place])


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def match_rows(left, right, first, last, disparity, crossings):
    """disparity[y, x] = x - x' with right[y, x'] = left[y, x], x' between pixels by straight lines; NaN for none.

    left, right (h, w): columns, NaN unknown; first, last: least and greatest disparity tried; crossings (h, w): how
    many places of the row would do. Of several, the one whose slope is the usual one (columns grow with x) and
    nearest to the left pixel's own slope is taken.
    """
    height, width = left.shape
    lows, highs = np.empty(width // BLOCK + 1), np.empty(width // BLOCK + 1)
    for y in range(height):
        _row_ranges(right[y], lows, highs)
        for x in range(width):
            disparity[y, x] = np.nan
            crossings[y, x] = 0
            value = left[y, x]
            if not np.isfinite(value):
                continue
            own = np.nan
            if 0 < x < width - 1:
                own = (left[y, x + 1] - left[y, x - 1]) / 2
            nearest = np.inf
            place, end = max(0, int(x - last)), min(width - 1, int(x - first) + 1)
            while place < end:
                block = place // BLOCK
                if value < lows[block] or value > highs[block]:
                    place = (block + 1) * BLOCK
                    continue
                a, b = right[y, place] - value, right[y, place + 1] - value
                place += 1
                if not (np.isfinite(a) and np.isfinite(b)) or (a > 0) == (b > 0) or a == b:
                    continue
                slope = b - a
                off = abs(slope - own) if np.isfinite(own) else abs(slope)
                crossings[y, x] += 1
                if off < nearest:
                    nearest = off
                    disparity[y, x] = x - (place - 1 + a / (a - b))
