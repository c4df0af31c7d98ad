"""Numpy twins of `icp`."""

import numpy as np


def correspond(points, normals, depth, intrinsics, reach, agree, step):
    """The depth pixel on which each vertex falls, where it may be trusted: found, plane, weight."""
    fx, fy, cx, cy = intrinsics
    h, w = depth.shape
    x, y, z = points.T.astype(float)
    safe = np.where(z > 1, z, np.inf)
    u, v = np.floor(fx * x / safe + cx + 0.5).astype(int), np.floor(fy * y / safe + cy + 0.5).astype(int)
    good = (z > 1) & (-(normals * points).sum(1) >= agree * np.linalg.norm(points, axis=1))
    good &= (u >= step) & (v >= step) & (u < w - step) & (v < h - step)
    u, v = np.where(good, u, step), np.where(good, v, step)
    steps = ((0, 0), (0, -step), (0, step), (-step, 0), (step, 0))
    here, left, right, up, down = (_pixels(depth, u + dx, v + dy, intrinsics) for dy, dx in steps)
    good &= np.isfinite(here + left + right + up + down).all(1)
    with np.errstate(invalid="ignore"):
        good &= np.linalg.norm(here - points, axis=1) <= reach
        good &= np.maximum(abs(left - right)[:, 2], abs(up - down)[:, 2]) <= reach
        plane = np.cross(down - up, right - left)
        plane /= np.linalg.norm(plane, axis=1, keepdims=True)
        good &= (plane * normals).sum(1) >= agree
        weight = -(plane * here).sum(1) / np.linalg.norm(here, axis=1)
    keep = good[:, None]
    found = (np.where(keep, here, 0), np.where(keep, plane, 0), np.where(good, weight, 0))
    return tuple(a.astype(np.float32) for a in found)


def _pixels(depth, u, v, intrinsics):
    fx, fy, cx, cy = intrinsics
    d = np.where(depth > 0, depth, np.nan)[v, u].astype(float)
    return np.stack([(u - cx) / fx * d, (v - cy) / fy * d, d], 1)


def rigid_system(points, found, plane, weight, centre, scale):
    """Normal equations of one point-to-plane step: A, b, mean |r|, how many."""
    keep = weight > 0
    p, q, n = points[keep].astype(float), found[keep].astype(float), plane[keep].astype(float)
    r = (n * (q - p)).sum(1)
    w = weight[keep] / (1 + (r / scale) ** 2) ** 2
    rows = np.concatenate([np.cross(p - centre, n), n], 1)
    return rows.T @ (w[:, None] * rows), rows.T @ (w * r), np.abs(r).mean() if keep.any() else 0.0, int(keep.sum())
