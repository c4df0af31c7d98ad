"""Quadratic patches fitted round every vertex of a mesh. `curvature_twin` has the numpy twin."""

from typing import no_type_check

import numpy as np
from numba import njit

from ._spread import spread

_COMPILE = {"cache": True, "nogil": True, "error_model": "numpy"}
LEAST = 9
"""Points beyond which a vertex outside the ball is left out: a fit of six unknowns needs some to spare."""


@no_type_check
@njit(**_COMPILE)
def _solve(A, b):
    """Solve the symmetric A x = b in place by Cholesky's factors; False where A is not positive definite."""
    n = len(b)
    for i in range(n):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i == j:
                if total <= 1e-12 * A[0, 0]:
                    return False
                A[i, i] = np.sqrt(total)
            else:
                A[i, j] = total / A[j, j]
    for i in range(n):
        for k in range(i):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= A[k, i] * b[k]
        b[i] /= A[i, i]
    return True


@no_type_check
@njit(inline="always")
def _between(vertices, i, j):
    """From vertex i to vertex j."""
    return vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1], vertices[j, 2] - vertices[i, 2]


@no_type_check
@njit(**_COMPILE)
def _gather(centre, radius, vertices, starts, neighbours, seen, found):
    """Vertices joined to `centre` by edges inside the ball, into found[1:]; marks them with `centre` in `seen`."""
    seen[centre], found[0] = centre, centre
    count, first, last = 1, 0, 1
    while first < last and count < len(found):
        for f in range(first, last):
            for at in range(starts[found[f]], starts[found[f] + 1]):
                j = neighbours[at]
                if seen[j] == centre or count == len(found):
                    continue
                x, y, z = _between(vertices, centre, j)
                if x * x + y * y + z * z <= radius * radius or count <= LEAST:
                    seen[j], found[count] = centre, j
                    count += 1
        first, last = last, count
    return count


@no_type_check
@njit(**_COMPILE)
def _fit(centre, found, vertices, normal, A, b, row):
    """Mean curvature at the centre of a height field over the normal's plane; 0 where there is no fit."""
    nx, ny, nz = normal[0], normal[1], normal[2]
    ex, ey, ez = (0.0, -nz, ny) if abs(nx) < 0.6 else (nz, 0.0, -nx)  # across the normal and the x or y axis
    length = np.sqrt(ex * ex + ey * ey + ez * ez)
    ex, ey, ez = ex / length, ey / length, ez / length
    fx, fy, fz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
    size = 0.0
    for j in found:
        x, y, z = _between(vertices, centre, j)
        size = max(size, np.sqrt(x * x + y * y + z * z))
    if size == 0.0:
        return 0.0
    A[:], b[:] = 0.0, 0.0
    for j in found:
        dx, dy, dz = _between(vertices, centre, j)
        x = (dx * ex + dy * ey + dz * ez) / size
        y = (dx * fx + dy * fy + dz * fz) / size
        z = (dx * nx + dy * ny + dz * nz) / size
        row[0], row[1], row[2], row[3], row[4], row[5] = 1.0, x, y, x * x / 2, x * y, y * y / 2
        for p in range(6):
            b[p] += row[p] * z
            for q in range(p + 1):
                A[p, q] += row[p] * row[q]
    if not _solve(A, b):
        return 0.0
    p, q = b[1], b[2]
    slope = 1 + p * p + q * q
    return -((1 + q * q) * b[3] - 2 * p * q * b[4] + (1 + p * p) * b[5]) / (2 * slope * np.sqrt(slope) * size)


def patch_curvature(vertices, normals, starts, neighbours, radius):
    """Mean curvature (n), 1 / the vertices' unit, from quadratic patches through all vertices within `radius`.

    starts (n + 1), neighbours: adjacency by rows. Only vertices joined to the centre inside the ball count: the other
    lip, however close, does not.
    """
    n = len(vertices)
    result = np.zeros(n)
    spread(lambda a, b: _patches(vertices, normals, starts, neighbours, radius, a, b, result), n)
    return result


@no_type_check
@njit(**_COMPILE)
def _patches(vertices, normals, starts, neighbours, radius, first, last, result):
    seen, found = np.full(len(vertices), -1, np.int64), np.empty(4096, np.int64)
    A, b, row = np.zeros((6, 6)), np.zeros(6), np.zeros(6)
    for i in range(first, last):
        count = _gather(i, radius, vertices, starts, neighbours, seen, found)
        if count > 6:
            result[i] = _fit(i, found[:count], vertices, normals[i], A, b, row)
