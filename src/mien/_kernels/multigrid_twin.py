"""Numpy twin of `multigrid`."""

import numpy as np


def relax(f, right, across, down, inverse, colour):
    """Solve at the places of one colour of a chessboard."""
    y, x = np.mgrid[: f.shape[0], : f.shape[1]]
    mine = (x + y) % 2 == colour
    weight = np.zeros_like(f)
    off = np.empty_like(f)
    applied(np.where(mine, 0.0, f), weight, across, down, off)
    f[mine] = ((right - off) * inverse)[mine]


def applied(f, weight, across, down, out):
    """out = A f."""
    out[:] = weight * f
    flux = across * np.diff(f, axis=1)
    out[:, :-1] -= flux
    out[:, 1:] += flux
    flux = down * np.diff(f, axis=0)
    out[:-1] -= flux
    out[1:] += flux


def sum_fours(image, coarse):
    """Sums of each two by two places."""
    rows = np.add.reduceat(image, np.arange(0, image.shape[0], 2), axis=0)
    coarse[:] = np.add.reduceat(rows, np.arange(0, image.shape[1], 2), axis=1)


def add_to_fours(image, coarse):
    """Each coarse value added to its two by two places."""
    image += coarse.repeat(2, axis=0).repeat(2, axis=1)[: image.shape[0], : image.shape[1]]
