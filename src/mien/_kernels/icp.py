"""Projective correspondences between a mesh and a depth image, and the normal equations of rigid point-to-plane ICP."""

from typing import no_type_check

import numba
import numpy as np

MATHS = {"reassoc", "contract", "arcp", "nsz"}


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def correspond(points, normals, depth, intrinsics, reach, agree, step):
    """The depth pixel on which each vertex falls, where it may be trusted (Rusinkiewicz and Levoy 2001).

    Args:
        points, normals: (n, 3) float32, camera space; normals point out of the surface.
        depth: (h, w) float32, mm; 0 or NaN = none.
        intrinsics: fx, fy, cx, cy of that image, float64.
        reach: mm; farther correspondences are pruned.
        agree: least cosine between the two normals, and of the vertex normal to the line of sight.
        step: pixels over which the depth's normal is measured.

    Returns:
        found (n, 3) float32: the pixel's point; plane (n, 3) float32: its unit normal, towards the camera;
        weight (n,) float32: cosine between line of sight and plane, 0 where pruned.
    """
    n = points.shape[0]
    found, plane, weight = np.zeros((n, 3), np.float32), np.zeros((n, 3), np.float32), np.zeros(n, np.float32)
    fx, fy, cx, cy = np.float32(intrinsics[0]), np.float32(intrinsics[1]), intrinsics[2], intrinsics[3]
    h, w = depth.shape
    for i in range(n):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        length = np.sqrt(x * x + y * y + z * z)
        if not z > 1 or -(nx * x + ny * y + nz * z) < agree * length:
            continue
        u, v = int(np.floor(fx * x / z + cx + 0.5)), int(np.floor(fy * y / z + cy + 0.5))
        if u < step or v < step or u >= w - step or v >= h - step:
            continue
        d = depth[v, u]
        left, right, up, down = depth[v, u - step], depth[v, u + step], depth[v - step, u], depth[v + step, u]
        if not (d > 0 and left > 0 and right > 0 and up > 0 and down > 0):
            continue
        a, b = np.float32((u - cx) / fx), np.float32((v - cy) / fy)
        px, py = a * d, b * d
        dx, dy, dz = px - x, py - y, d - z
        if dx * dx + dy * dy + dz * dz > reach * reach:
            continue
        if max(abs(left - right), abs(up - down)) > reach:
            continue
        sx, sy = step / fx, step / fy
        tx, ty, tz = a * (right - left) + sx * (right + left), b * (right - left), right - left
        bx, by, bz = a * (down - up), b * (down - up) + sy * (down + up), down - up
        mx, my, mz = by * tz - bz * ty, bz * tx - bx * tz, bx * ty - by * tx
        size = np.sqrt(mx * mx + my * my + mz * mz)
        mx, my, mz = mx / size, my / size, mz / size
        if mx * nx + my * ny + mz * nz < agree:
            continue
        found[i, 0], found[i, 1], found[i, 2] = px, py, d
        plane[i, 0], plane[i, 1], plane[i, 2] = mx, my, mz
        weight[i] = -(mx * px + my * py + mz * d) / np.sqrt(px * px + py * py + d * d)
    return found, plane, weight


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def rigid_system(points, found, plane, weight, centre, scale):
    """Normal equations of one point-to-plane step for a small turn about `centre` and a shift.

    Args:
        points, found, plane: (n, 3) float32; weight (n,) float32, 0 = left out.
        centre: (3,) float64.
        scale: mm; residuals much above it lose weight as 1 / (1 + (r / scale)^2)^2.

    Returns:
        A (6, 6), b (6,) float64 with A @ [turn, shift] = b; mean |r| of what was kept, mm; how many that is.
    """
    A, b = np.zeros((6, 6)), np.zeros(6)
    row = np.zeros(6)
    total, kept = 0.0, 0
    for i in range(points.shape[0]):
        if weight[i] <= 0:
            continue
        nx, ny, nz = plane[i, 0], plane[i, 1], plane[i, 2]
        x, y, z = points[i, 0] - centre[0], points[i, 1] - centre[1], points[i, 2] - centre[2]
        r = nx * (found[i, 0] - points[i, 0]) + ny * (found[i, 1] - points[i, 1]) + nz * (found[i, 2] - points[i, 2])
        soft = 1.0 / (1.0 + (r / scale) ** 2)
        w = weight[i] * soft * soft
        row[0], row[1], row[2] = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
        row[3], row[4], row[5] = nx, ny, nz
        for p in range(6):
            for q in range(p, 6):
                A[p, q] += w * row[p] * row[q]
            b[p] += w * row[p] * r
        total += abs(r)
        kept += 1
    for p in range(6):
        for q in range(p):
            A[p, q] = A[q, p]
    return A, b, total / max(kept, 1), kept
