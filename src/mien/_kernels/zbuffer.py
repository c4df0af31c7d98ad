"""Visibility through a pinhole camera: the nearest triangle on the ray of every pixel, compiled."""

from typing import no_type_check

import numpy as np
from numba import njit

from ._spread import spread

NEAR = 1e-3
"""A triangle with a corner nearer than this (mm) has no bounded projection: every pixel is tried on it."""


def zbuffer(points, faces, intrinsics, height, width, threads=0):
    """Cast the ray of every pixel centre at triangles in camera space; float64, watertight along shared edges.

    Args:
        points: (n, 3) camera space.
        faces: (m, 3).
        intrinsics: fx, fy, cx, cy in pixels.
        threads: bands of rows are shared out over as many; 0 = one a core.

    Returns:
        faces (h, w) int32, -1 where nothing is hit; 1 / depth z (h, w) float64, 0 there.
    """
    face_image = np.full((height, width), -1, dtype=np.int32)
    nearness = np.zeros((height, width))
    points, faces, dx, dy = _prepared(points, faces, intrinsics, height, width)
    fx, fy, cx, cy = (float(i) for i in intrinsics)
    box = _boxes(points, faces, fx, fy, cx, cy, width, height)
    spread(lambda a, b: _fill(points, faces, box, dx, dy, a, b, face_image, nearness), height, threads)
    return face_image, nearness


def pixel_weights(points, faces, intrinsics, face_image, pixels, threads=0):
    """Barycentric coordinates (p, 3) float64 where the rays of `pixels` (p,), flat indices, meet their triangles."""
    height, width = face_image.shape
    points, faces, dx, dy = _prepared(points, faces, intrinsics, height, width)
    weights = np.empty((len(pixels), 3))
    flat = face_image.reshape(-1)
    spread(lambda a, b: _weigh(points, faces, dx, dy, flat, pixels, a, b, weights), len(pixels), threads)
    return weights


def _prepared(points, faces, intrinsics, height, width):
    fx, fy, cx, cy = intrinsics
    points = np.ascontiguousarray(points, dtype=np.float64)
    faces = np.ascontiguousarray(faces, dtype=np.int64)
    return points, faces, (np.arange(width) - cx) / fx, (np.arange(height) - cy) / fy


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy")
def _boxes(points, faces, fx, fy, cx, cy, width, height):
    """Pixel ranges left, right, top, bottom (inclusive) that can see each triangle; left > right where none can."""
    box = np.empty((len(faces), 4), np.int32)
    for f in range(len(faces)):
        left, right, top, bottom = float(width), -1.0, float(height), -1.0
        near, far = np.inf, -np.inf
        for corner in range(3):
            x, y, z = points[faces[f, corner]]
            near, far = min(near, z), max(far, z)
            if z > NEAR:
                u, v = fx * x / z + cx, fy * y / z + cy
                left, right, top, bottom = min(left, u), max(right, u), min(top, v), max(bottom, v)
        if near <= NEAR and far > 0:
            left, right, top, bottom = 0.0, width - 1.0, 0.0, height - 1.0
        box[f, 0] = int(np.ceil(max(left - 1e-6, 0.0)))
        box[f, 1] = int(np.floor(min(max(right + 1e-6, -1.0), width - 1.0)))
        box[f, 2] = int(np.ceil(max(top - 1e-6, 0.0)))
        box[f, 3] = int(np.floor(min(max(bottom + 1e-6, -1.0), height - 1.0)))
    return box


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy")
def _edges(points, faces, f):
    """Rows of det M times M^-1 for M = [a b c], and det M. On a ray d through the triangle t d = M beta, so
    beta / t = M^-1 d: each row b x c, c x a, a x b is one edge's function, equal but for sign in its neighbour."""
    ax, ay, az = points[faces[f, 0]]
    bx, by, bz = points[faces[f, 1]]
    gx, gy, gz = points[faces[f, 2]]
    e0 = (by * gz - bz * gy, bz * gx - bx * gz, bx * gy - by * gx)
    e1 = (gy * az - gz * ay, gz * ax - gx * az, gx * ay - gy * ax)
    e2 = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
    return e0, e1, e2, ax * e0[0] + ay * e0[1] + az * e0[2]


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy")
def _fill(points, faces, box, dx, dy, first, last, face_image, nearness):
    """Faces and 1/z of the rows first..last-1."""
    for f in range(len(faces)):
        left, right = box[f, 0], box[f, 1]
        top, bottom = max(box[f, 2], first), min(box[f, 3], last - 1)
        if left > right or top > bottom:
            continue
        (e0x, e0y, e0z), (e1x, e1y, e1z), (e2x, e2y, e2z), det = _edges(points, faces, f)
        if det == 0:
            continue
        side = 1.0 if det > 0 else -1.0
        scale = 1 / abs(det)
        for v in range(top, bottom + 1):
            r0 = e0y * dy[v] + e0z
            r1 = e1y * dy[v] + e1z
            r2 = e2y * dy[v] + e2z
            for u in range(left, right + 1):
                w0 = side * (e0x * dx[u] + r0)
                w1 = side * (e1x * dx[u] + r1)
                w2 = side * (e2x * dx[u] + r2)
                if w0 >= 0 and w1 >= 0 and w2 >= 0:
                    q = (w0 + w1 + w2) * scale
                    if q > nearness[v, u]:
                        nearness[v, u] = q
                        face_image[v, u] = f


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy")
def _weigh(points, faces, dx, dy, flat, pixels, first, last, weights):
    """Barycentric coordinates of pixels first..last-1."""
    width = len(dx)
    for p in range(first, last):
        v, u = divmod(pixels[p], width)
        e0, e1, e2, _ = _edges(points, faces, flat[pixels[p]])
        w0 = e0[0] * dx[u] + (e0[1] * dy[v] + e0[2])
        w1 = e1[0] * dx[u] + (e1[1] * dy[v] + e1[2])
        w2 = e2[0] * dx[u] + (e2[1] * dy[v] + e2[2])
        total = w0 + w1 + w2
        weights[p, 0] = w0 / total
        weights[p, 1] = w1 / total
        weights[p, 2] = w2 / total
