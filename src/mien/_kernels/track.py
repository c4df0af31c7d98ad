"""Inner loops of the tracker: vertex normals, rows of the blendshape fit, solves with one constant factor."""

from typing import no_type_check

import numba
import numpy as np

MATHS = {"reassoc", "contract", "arcp", "nsz"}

BLOCK = 256
"""Rows of normal equations worked on at a time."""


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def vertex_normals(vertices, faces):
    """Unit, area-weighted (n, 3) float32 of a float32 mesh; zero for a vertex of no triangle."""
    out = np.zeros_like(vertices)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x, y, z = vertices[a, 0], vertices[a, 1], vertices[a, 2]
        ux, uy, uz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        vx, vy, vz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        for i in (a, b, c):
            out[i, 0] += nx
            out[i, 1] += ny
            out[i, 2] += nz
    for i in range(out.shape[0]):
        length = np.sqrt(out[i, 0] ** 2 + out[i, 1] ** 2 + out[i, 2] ** 2)
        if length > 0:
            for d in range(3):
                out[i, d] /= length
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def place(vertices, rotation, translation):
    """rotation @ v + translation for every row (n, 3) float32; rotation (3, 3) and translation (3,) float64."""
    out = np.empty_like(vertices)
    R, t = rotation.astype(np.float32), translation.astype(np.float32)
    for i in range(vertices.shape[0]):
        x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        for d in range(3):
            out[i, d] = R[d, 0] * x + R[d, 1] * y + R[d, 2] * z + t[d]
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, error_model="numpy")
def turned(rotation, translation, motion, centre):
    """A pose followed by a turn motion[:3] (radians) about `centre` and a shift motion[3:]: rotation, translation."""
    angle = np.sqrt(motion[0] ** 2 + motion[1] ** 2 + motion[2] ** 2)
    a = np.sin(angle) / angle if angle > 1e-8 else 1.0
    b = (1 - np.cos(angle)) / angle**2 if angle > 1e-8 else 0.5
    R, t = np.empty((3, 3)), np.empty(3)
    v = np.empty((4, 3))
    for i in range(3):
        for j in range(3):
            v[j, i] = rotation[i, j]
        v[3, i] = translation[i] - centre[i]
    x, y, z = motion[0], motion[1], motion[2]
    for i in range(4):
        p, q, r = v[i, 0], v[i, 1], v[i, 2]
        c0, c1, c2 = y * r - z * q, z * p - x * r, x * q - y * p
        v[i, 0] += a * c0 + b * (y * c2 - z * c1)
        v[i, 1] += a * c1 + b * (z * c0 - x * c2)
        v[i, 2] += a * c2 + b * (x * c1 - y * c0)
    for i in range(3):
        for j in range(3):
            R[j, i] = v[i, j]
        t[i] = v[3, i] + centre[i] + motion[3 + i]
    return R, t


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def normal_equations(rows, right):
    """rows' rows (c, c) and rows' right (c,), float32, for tall float32 rows (m, c).

    Blocks of rows are turned on their side, so that the sums run along memory, four at a time; all in one thread: at
    this size a BLAS spends longer waking its threads up.
    """
    m, c = rows.shape
    wide = c + 1 + (c + 1) % 2
    A = np.zeros((wide, wide), np.float32)
    block = np.zeros((wide, BLOCK), np.float32)
    for start in range(0, m, BLOCK):
        n = min(BLOCK, m - start)
        for i in range(n):
            for p in range(c):
                block[p, i] = rows[start + i, p]
            block[c, i] = right[start + i]
        for p in range(0, wide, 2):
            a0, a1 = block[p], block[p + 1]
            for q in range(p, wide, 2):
                b0, b1 = block[q], block[q + 1]
                s00, s01, s10, s11 = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
                for i in range(n):
                    s00 += a0[i] * b0[i]
                    s01 += a0[i] * b1[i]
                    s10 += a1[i] * b0[i]
                    s11 += a1[i] * b1[i]
                A[p, q] += s00
                A[p, q + 1] += s01
                A[p + 1, q] += s10
                A[p + 1, q + 1] += s11
    for p in range(wide):
        for q in range(p):
            A[p, q] = A[q, p]
    return A[:c, :c].copy(), A[:c, c].copy()


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def solve_factored(starts, indices, values, inverse, order, right):
    """Solve P' L D L' P x = right for the columns of `right` (n, 3) at once, float32; L unit lower, without diagonal.

    starts (n + 1,), indices, values: L by columns; inverse (n,): of D; order (n,): row i of P right is right[order[i]].
    Rows are kept four wide, the width of a machine word of floats; unsigned indices spare the check for negative ones.
    """
    n = inverse.size
    four, one, two, three = np.uint64(4), np.uint64(1), np.uint64(2), np.uint64(3)
    y = np.zeros(4 * n, np.float32)
    for i in range(n):
        y[4 * i], y[4 * i + 1], y[4 * i + 2] = right[order[i], 0], right[order[i], 1], right[order[i], 2]
    for j in range(n):
        a, b, c, d = y[4 * j], y[4 * j + 1], y[4 * j + 2], y[4 * j + 3]
        for p in range(starts[j], starts[j + 1]):
            i, value = four * indices[p], values[p]
            y[i] -= value * a
            y[i + one] -= value * b
            y[i + two] -= value * c
            y[i + three] -= value * d
    out = np.empty((n, 3), np.float32)
    for j in range(n - 1, -1, -1):
        by = inverse[j]
        a, b, c, d = y[4 * j] * by, y[4 * j + 1] * by, y[4 * j + 2] * by, y[4 * j + 3] * by
        for p in range(starts[j], starts[j + 1]):
            i, value = four * indices[p], values[p]
            a -= value * y[i]
            b -= value * y[i + one]
            c -= value * y[i + two]
            d -= value * y[i + three]
        y[4 * j], y[4 * j + 1], y[4 * j + 2], y[4 * j + 3] = a, b, c, d
        out[order[j], 0], out[order[j], 1], out[order[j], 2] = a, b, c
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def plane_offsets(points, found, plane, weight, rotation):
    """From each vertex to the foot on its depth pixel's plane, in face space (n, 3) float32; 0 where weight is 0."""
    out = np.zeros_like(points)
    R = rotation.astype(np.float32)
    for i in range(points.shape[0]):
        if weight[i] > 0:
            nx, ny, nz = plane[i, 0], plane[i, 1], plane[i, 2]
            r = nx * (found[i, 0] - points[i, 0]) + ny * (found[i, 1] - points[i, 1])
            r += nz * (found[i, 2] - points[i, 2])
            for d in range(3):
                out[i, d] = r * (nx * R[0, d] + ny * R[1, d] + nz * R[2, d])
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def mean_square(share, displacement):
    """Sum of share (n,) times the squared length of displacement (n, 3), float32."""
    total = np.float32(0)
    for i in range(share.size):
        x, y, z = displacement[i, 0], displacement[i, 1], displacement[i, 2]
        total += share[i] * (x * x + y * y + z * z)
    return total
