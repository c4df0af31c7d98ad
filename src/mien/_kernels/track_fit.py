"""Inner loops of the blendshape fit. Shapes are local, so vertices are taken in blocks that few shapes move."""

from typing import no_type_check

import numba
import numpy as np

MATHS = {"reassoc", "contract", "arcp", "nsz"}

BLOCK = 64
"""Vertices of a block."""


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def blend(neutral, order, columns, values, weights):
    """neutral + sum of the shapes times `weights` (k,), (n, 3) float32; blocks as in `plane_system`."""
    out = neutral.copy()
    moved = np.empty((3, BLOCK), np.float32)
    for b in range(order.shape[0]):
        moved[:] = 0
        for c in range(columns.shape[1]):
            if columns[b, c] < 0:
                break
            w = np.float32(weights[columns[b, c]])
            if w != 0:
                for d in range(3):
                    for j in range(BLOCK):
                        moved[d, j] += w * values[b, d, c, j]
        for j in range(BLOCK):
            i = order[b, j]
            if i >= 0:
                for d in range(3):
                    out[i, d] += moved[d, j]
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def add_gram(rows, count, places, total):
    """total[places, places] += rows rows' for the first `count` rows (even), upper half; rows (r, BLOCK) float32."""
    for p in range(0, count, 2):
        a0, a1 = rows[p], rows[p + 1]
        for q in range(p, count, 2):
            b0, b1 = rows[q], rows[q + 1]
            s00, s01, s10, s11 = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
            for j in range(BLOCK):
                s00 += a0[j] * b0[j]
                s01 += a0[j] * b1[j]
                s10 += a1[j] * b0[j]
                s11 += a1[j] * b1[j]
            total[places[p], places[q]] += s00
            total[places[p], places[q + 1]] += s01
            total[places[p + 1], places[q]] += s10 if q > p else 0
            total[places[p + 1], places[q + 1]] += s11


@no_type_check
@numba.njit(cache=True, nogil=True, error_model="numpy")
def mirror(square):
    """Copy the upper half to the lower, in place."""
    for p in range(square.shape[0]):
        for q in range(p):
            square[p, q] = square[q, p]


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def plane_system(order, columns, values, k, rotation, points, found, plane, weight, share, centre, scale, lever):
    """Normal equations of the point-to-plane term (Li et al. 2013, eq. 1) and of a small turn and shift of the head.

    Args:
        order: (blocks, BLOCK) int32, the vertices of each block, -1 where it is not full.
        columns: (blocks, w) int32, ascending, the shapes that move them, -1 after the last; out of `k`.
        values: (blocks, 3, w, BLOCK) float32, these shapes in face space.
        rotation: (3, 3) float64, camera from face.
        points, found, plane, weight, share: as `icp.correspond` gives; (n,) float32, further weight.
        centre: (3,) float64, what the head turns about; turns are counted in 1 / `lever`.
        scale: mm; rows with larger residuals lose weight as 1 / (1 + (r / scale)^2)^2.

    Returns:
        A (k + 6, k + 6), b (k + 6,) float64 with A @ [weights, turn, shift] = b; mean |r| of what corresponds, mm,
        0 for nothing; sum of its shares.
    """
    w = columns.shape[1]
    R = rotation.astype(np.float32)
    total = np.zeros((k + 8, k + 8))
    rows, f = np.zeros((w + 8, BLOCK), np.float32), np.zeros((3, BLOCK), np.float32)
    fx, fy, fz = f[0], f[1], f[2]
    places = np.empty(w + 8, np.int64)
    cx, cy, cz, s = np.float32(centre[0]), np.float32(centre[1]), np.float32(centre[2]), np.float32(1 / scale)
    one, turn, away, kept, covered = np.float32(1), np.float32(1 / lever), 0.0, 0, 0.0
    for b in range(order.shape[0]):
        n, before = 0, kept
        while n < w and columns[b, n] >= 0:
            places[n] = columns[b, n]
            n += 1
        for p in range(8):
            places[n + p] = k + p
        pose = rows[n : n + 8]
        pose[:] = 0
        for j in range(BLOCK):
            fx[j], fy[j], fz[j] = 0, 0, 0
            i = order[b, j]
            if i < 0 or weight[i] <= 0:
                continue
            nx, ny, nz = plane[i, 0], plane[i, 1], plane[i, 2]
            px, py, pz = points[i, 0], points[i, 1], points[i, 2]
            r = nx * (found[i, 0] - px) + ny * (found[i, 1] - py) + nz * (found[i, 2] - pz)
            root = np.sqrt(weight[i] * share[i]) / (one + (r * s) ** 2)
            fx[j] = root * (R[0, 0] * nx + R[1, 0] * ny + R[2, 0] * nz)
            fy[j] = root * (R[0, 1] * nx + R[1, 1] * ny + R[2, 1] * nz)
            fz[j] = root * (R[0, 2] * nx + R[1, 2] * ny + R[2, 2] * nz)
            x, y, z = (px - cx) * turn, (py - cy) * turn, (pz - cz) * turn
            tx, ty, tz = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
            pose[0, j], pose[1, j], pose[2, j] = root * tx, root * ty, root * tz
            pose[3, j], pose[4, j], pose[5, j], pose[6, j] = root * nx, root * ny, root * nz, root * r
            away += abs(r)
            kept += 1
            covered += share[i]
        if kept == before:
            continue
        for c in range(n):
            for j in range(BLOCK):
                rows[c, j] = fx[j] * values[b, 0, c, j] + fy[j] * values[b, 1, c, j] + fz[j] * values[b, 2, c, j]
        add_gram(rows, n + 7 + (n + 7) % 2, places, total)
    mirror(total)
    return total[: k + 6, : k + 6].copy(), total[: k + 6, k + 6].copy(), away / max(kept, 1), covered


@no_type_check
@numba.njit(cache=True, nogil=True, error_model="numpy")
def landmark_rows(neutral, basis, weights, rotation, translation, centre, lever):
    """Landmarks in camera space and their derivatives by weights, turn (in 1 / lever, about `centre`) and shift.

    neutral (j, 3), basis (j, 3, k), weights (k,), float64, face space. Returns J (j, 3, k + 6), points (j, 3).
    """
    count, _, k = basis.shape
    J, points = np.zeros((count, 3, k + 6)), np.empty((count, 3))
    v = np.empty(3)
    for j in range(count):
        for d in range(3):
            v[d] = neutral[j, d]
            for c in range(k):
                v[d] += basis[j, d, c] * weights[c]
        for e in range(3):
            points[j, e] = translation[e]
            for d in range(3):
                points[j, e] += rotation[e, d] * v[d]
                for c in range(k):
                    J[j, e, c] += rotation[e, d] * basis[j, d, c]
            J[j, e, k + 3 + e] = 1.0
        x, y, z = (points[j] - centre) / lever
        J[j, 0, k + 1], J[j, 0, k + 2] = z, -y
        J[j, 1, k], J[j, 1, k + 2] = -z, x
        J[j, 2, k], J[j, 2, k + 1] = y, -x
    return J, points
