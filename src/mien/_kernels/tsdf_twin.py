"""Numpy twin of `tsdf`."""

import numpy as np


def integrate(distance, weight, origin, voxel, rotation, translation, depth, intrinsics, truncation, most):
    """Average one depth image into the volume, in place."""
    index = np.stack(np.meshgrid(*(np.arange(n) for n in distance.shape), indexing="ij"), -1)
    points = (origin + index * voxel) @ rotation.T + translation
    fx, fy, cx, cy = intrinsics
    h, w = depth.shape
    z = np.where(points[..., 2] > 1, points[..., 2], np.inf)
    u = np.floor(fx * points[..., 0] / z + cx + 0.5).astype(int)
    v = np.floor(fy * points[..., 1] / z + cy + 0.5).astype(int)
    good = np.isfinite(z) & (u >= 0) & (v >= 0) & (u < w) & (v < h)
    seen = np.where(depth > 0, depth, np.nan)[np.where(good, v, 0), np.where(good, u, 0)]
    with np.errstate(invalid="ignore"):
        away = np.minimum((seen - z) / truncation, 1.0)
        good &= away >= -1
    averaged = (weight * distance + np.nan_to_num(away)) / (weight + 1)
    distance[good] = averaged[good]
    weight[good] = np.minimum(weight + 1, most)[good]
