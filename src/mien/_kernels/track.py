"""Inner loops of the tracker: vertex normals, rows of the blendshape fit, solves with one constant factor."""

from typing import no_type_check

import numba
import numpy as np

MATHS = {"reassoc", "contract", "arcp", "nsz"}


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

    Four rows at a time, in one thread: at this size a BLAS spends longer waking its threads up.
    """
    m, c = rows.shape
    A, b = np.zeros((c, c), np.float32), np.zeros(c, np.float32)
    for i in range(0, m - 3, 4):
        r0, r1, r2, r3 = rows[i], rows[i + 1], rows[i + 2], rows[i + 3]
        s0, s1, s2, s3 = right[i], right[i + 1], right[i + 2], right[i + 3]
        for p in range(c):
            a0, a1, a2, a3 = r0[p], r1[p], r2[p], r3[p]
            line = A[p]
            for q in range(p, c):
                line[q] += a0 * r0[q] + a1 * r1[q] + a2 * r2[q] + a3 * r3[q]
            b[p] += a0 * s0 + a1 * s1 + a2 * s2 + a3 * s3
    for i in range(m - m % 4, m):
        for p in range(c):
            for q in range(p, c):
                A[p, q] += rows[i, p] * rows[i, q]
            b[p] += rows[i, p] * right[i]
    for p in range(c):
        for q in range(p):
            A[p, q] = A[q, p]
    return A, b


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
