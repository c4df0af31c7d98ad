"""Numpy twin of `epipolar`."""

import numpy as np


def match_rows(left, right, first, last, disparity, crossings):
    """disparity[y, x] = x - x' with right[y, x'] = left[y, x], x' between pixels by straight lines; NaN for none."""
    height, width = left.shape
    disparity[:], crossings[:] = np.nan, 0
    own = np.full(left.shape, np.nan)
    own[:, 1:-1] = (left[:, 2:] - left[:, :-2]) / 2
    for y in range(height):
        for x in np.flatnonzero(np.isfinite(left[y])):
            places = np.arange(max(0, int(x - last)), min(width - 1, int(x - first) + 1))
            a, b = right[y, places] - left[y, x], right[y, places + 1] - left[y, x]
            with np.errstate(invalid="ignore", divide="ignore"):
                crossed = np.isfinite(a) & np.isfinite(b) & ((a > 0) != (b > 0)) & (a != b)
                at = places + a / (a - b)
            crossings[y, x] = crossed.sum()
            if crossed.any():
                off = np.abs((b - a) - (own[y, x] if np.isfinite(own[y, x]) else 0.0))
                disparity[y, x] = x - at[np.argmin(np.where(crossed, off, np.inf))]
