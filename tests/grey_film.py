"""A film whose frames tell their numbers."""

import numpy as np

from mien.pictures import write_mp4


def film(path, frames, rate=10.0):
    """A film whose frame n has the grey value 4 n."""
    write_mp4(path, (np.full((32, 48, 3), 4 * n, np.uint8) for n in range(frames)), rate)
    return path
