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
    v[:3] = rotation.T
    v[3] = translation - centre
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
def plane_rows(basis, rotation, points, found, plane, weight, centre, scale):
    """Rows of the point-to-plane term (Li et al. 2013, eq. 1) and of a small turn and shift of the head.

    Args:
        basis: (n, 3, k) float32, the shapes in face space.
        rotation: (3, 3) float64, camera from face.
        points, found, plane: (n, 3) float32, camera space, as `icp.correspond` gives; weight (n,) float32.
        centre: (3,) float64, what the head turns about.
        scale: mm; rows with larger residuals lose weight as 1 / (1 + (r / scale)^2)^2.

    Returns:
        rows (m, k + 6) float32 and right-hand side (m,) float32, both times the root of the weight; m rows are kept.
    """
    n, _, k = basis.shape
    rows, right = np.empty((n, k + 6), np.float32), np.empty(n, np.float32)
    R = rotation.astype(np.float32)
    m = 0
    for i in range(n):
        if weight[i] <= 0:
            continue
        nx, ny, nz = plane[i, 0], plane[i, 1], plane[i, 2]
        r = nx * (found[i, 0] - points[i, 0]) + ny * (found[i, 1] - points[i, 1]) + nz * (found[i, 2] - points[i, 2])
        root = np.float32(np.sqrt(weight[i]) / (1 + (r / scale) ** 2))
        fx = root * (R[0, 0] * nx + R[1, 0] * ny + R[2, 0] * nz)
        fy = root * (R[0, 1] * nx + R[1, 1] * ny + R[2, 1] * nz)
        fz = root * (R[0, 2] * nx + R[1, 2] * ny + R[2, 2] * nz)
        row, shapes = rows[m], basis[i]
        for c in range(k):
            row[c] = fx * shapes[0, c] + fy * shapes[1, c] + fz * shapes[2, c]
        x, y, z = points[i, 0] - centre[0], points[i, 1] - centre[1], points[i, 2] - centre[2]
        row[k], row[k + 1], row[k + 2] = root * (y * nz - z * ny), root * (z * nx - x * nz), root * (x * ny - y * nx)
        row[k + 3], row[k + 4], row[k + 5] = root * nx, root * ny, root * nz
        right[m] = root * r
        m += 1
    return rows[:m], right[:m]


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
def solve_factored(starts, indices, values, pivots, order, right):
    """Solve P' L D L' P x = right for the columns of `right` (n, 3) float64 at once; L unit lower, without diagonal.

    starts (n + 1,), indices, values: L by columns; pivots (n,): D; order (n,): row i of P right is right[order[i]].
    """
    n = pivots.size
    y = np.empty((n, 3))
    for i in range(n):
        y[i, 0], y[i, 1], y[i, 2] = right[order[i], 0], right[order[i], 1], right[order[i], 2]
    for j in range(n):
        a, b, c = y[j, 0], y[j, 1], y[j, 2]
        for p in range(starts[j], starts[j + 1]):
            i, value = indices[p], values[p]
            y[i, 0] -= value * a
            y[i, 1] -= value * b
            y[i, 2] -= value * c
    out = np.empty((n, 3))
    for j in range(n - 1, -1, -1):
        a, b, c = y[j, 0] / pivots[j], y[j, 1] / pivots[j], y[j, 2] / pivots[j]
        for p in range(starts[j], starts[j + 1]):
            i, value = indices[p], values[p]
            a -= value * y[i, 0]
            b -= value * y[i, 1]
            c -= value * y[i, 2]
        y[j, 0], y[j, 1], y[j, 2] = a, b, c
        out[order[j], 0], out[order[j], 1], out[order[j], 2] = a, b, c
    return out
