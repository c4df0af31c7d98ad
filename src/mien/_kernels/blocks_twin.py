"""Numpy twin of `blocks`."""

import numpy as np
from scipy import ndimage


def sum_blocks(values, rows, columns, step, sums):
    """Added up by block."""
    np.add.at(sums, (rows // step, columns // step), values)


def read_blocks(blocks, rows, columns, step, out):
    """Bilinear between the blocks' centres."""
    where = [(rows + 0.5) / step - 0.5, (columns + 0.5) / step - 0.5]
    for c in range(blocks.shape[2]):
        out[:, c] = ndimage.map_coordinates(blocks[..., c], where, order=1, mode="nearest")
