"""Parts of pages."""

import numpy as np


def flat(color, height=20, width=30):
    return np.full((height, width, 3), color, dtype=np.uint8)
