"""A screened Poisson equation on a grid with a weight at each place and each edge: what multigrid is made of.

Everywhere: f, right, weight, inverse (h, w); across (h, w-1) and down (h-1, w), weights of the edges to the next column
and row. The matrix A has `weight` and the sum of a place's edges on its diagonal, minus the edges off it.
"""

from typing import no_type_check

import numba as nb


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def relax(f, right, across, down, inverse, colour):
    """Solve A f = right at the places of one colour of a chessboard (0 or 1), the others as they are: f is written.

    inverse: 1 / diagonal; 0 where that is 0, and f with it.
    """
    h, w = f.shape
    for y in range(h):
        for x in range((y + colour) % 2, w, 2):
            total = right[y, x]
            if x > 0:
                total += across[y, x - 1] * f[y, x - 1]
            if x < w - 1:
                total += across[y, x] * f[y, x + 1]
            if y > 0:
                total += down[y - 1, x] * f[y - 1, x]
            if y < h - 1:
                total += down[y, x] * f[y + 1, x]
            f[y, x] = total * inverse[y, x]


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def applied(f, weight, across, down, out):
    """out = A f."""
    h, w = f.shape
    for y in range(h):
        for x in range(w):
            value = f[y, x]
            total = weight[y, x] * value
            if x > 0:
                total += across[y, x - 1] * (value - f[y, x - 1])
            if x < w - 1:
                total += across[y, x] * (value - f[y, x + 1])
            if y > 0:
                total += down[y - 1, x] * (value - f[y - 1, x])
            if y < h - 1:
                total += down[y, x] * (value - f[y + 1, x])
            out[y, x] = total


@no_type_check
@nb.njit(cache=True, nogil=True)
def sum_fours(image, coarse):
    """coarse (ceil(h / 2), ceil(w / 2)) is written: the sums of each two by two places."""
    coarse[:] = 0.0
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            coarse[y // 2, x // 2] += image[y, x]


@no_type_check
@nb.njit(cache=True, nogil=True)
def add_to_fours(image, coarse):
    """Each value of coarse is added to its two by two places of the image."""
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            image[y, x] += coarse[y // 2, x // 2]
