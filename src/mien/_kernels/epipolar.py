"""Along the rows of a rectified pair: where the right picture shows the left one's projector column."""

from typing import no_type_check

import numba as nb
import numpy as np


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def match_rows(left, right, first, last, disparity, crossings):
    """disparity[y, x] = x - x' with right[y, x'] = left[y, x], x' between pixels by straight lines; NaN for none.

    left, right (h, w): columns, NaN unknown; first, last: least and greatest disparity tried; crossings (h, w): how
    many places of the row would do. Of several, the one whose slope is the usual one (columns grow with x) and
    nearest to the left pixel's own slope is taken.
    """
    height, width = left.shape
    for y in range(height):
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
            for place in range(max(0, int(x - last)), min(width - 1, int(x - first) + 1)):
                a, b = right[y, place] - value, right[y, place + 1] - value
                if not (np.isfinite(a) and np.isfinite(b)) or (a > 0) == (b > 0) or a == b:
                    continue
                slope = b - a
                off = abs(slope - own) if np.isfinite(own) else abs(slope)
                crossings[y, x] += 1
                if off < nearest:
                    nearest = off
                    disparity[y, x] = x - (place + a / (a - b))
