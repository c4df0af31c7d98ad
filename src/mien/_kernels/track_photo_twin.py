"""`track_photo` in numpy, function by function."""

import numpy as np
from scipy.ndimage import uniform_filter


def box(image, radius):
    """As `mien._kernels.track_photo.box`."""
    side, inside = 2 * radius + 1, np.ones(image.shape)
    share = uniform_filter(inside, side, mode="constant")
    return uniform_filter(image.astype(float), side, mode="constant") / share


def grey(color):
    """As `mien._kernels.track_photo.grey`."""
    return color.astype(float) @ np.array([0.25, 0.5, 0.25])


def sample_plane(points, normals, image, intrinsics, reference, valid, agree):
    """As `mien._kernels.track_photo.sample_plane`."""
    (h, w), (fx, fy, cx, cy) = image.shape, intrinsics
    x, y, z = points.T.astype(float)
    ahead = z > 1
    depth = np.where(ahead, z, 1.0)
    facing = -(normals * points).sum(1) / np.maximum(np.linalg.norm(points, axis=1), 1e-12)
    u, v = fx * x / depth + cx, fy * y / depth + cy
    good = ahead & (facing >= agree) & (u >= 1) & (v >= 1) & (u < w - 2) & (v < h - 2)
    rows, columns = np.gradient(image.astype(float))
    shown, gu, gv = (np.where(good, _between(part, u, v, good), 0.0) for part in (image, columns, rows))
    gx, gy = gu * fx / depth, gv * fy / depth
    slope = np.stack([gx, gy, -(gx * x + gy * y) / depth], 1)
    square = (slope**2).sum(1)
    tells = good & (square > 1e-12)
    step = np.where(tells, (reference - shown) / np.where(tells, square, 1.0), 0.0)
    found = np.where(tells[:, None], points + step[:, None] * slope, 0.0)
    plane = np.where(tells[:, None], slope, 0.0)
    return found, plane, np.where(good, facing * valid, 0.0), shown


def _between(image, u, v, good):
    a, b = np.where(good, u, 1).astype(int), np.where(good, v, 1).astype(int)
    s, t = u - a, v - b
    above = (1 - s) * image[b, a] + s * image[b, a + 1]
    return (1 - t) * above + t * ((1 - s) * image[b + 1, a] + s * image[b + 1, a + 1])
