"""Numpy twins of `track_depth`."""

import numpy as np


def _windows(depth, radius):
    h, w = depth.shape
    padded = np.zeros((h + 2 * radius, w + 2 * radius), np.float32)
    padded[radius : radius + h, radius : radius + w] = np.where(depth > 0, depth, 0)
    return np.lib.stride_tricks.sliding_window_view(padded, (2 * radius + 1,) * 2).reshape(h, w, -1)


def bilateral(depth, radius, depth_sigma):
    """Edge-keeping smoothing (h, w) float32: box in space, (1 - (dz / 3 sigma)^2)^2 in depth; 0 where none is."""
    windows = _windows(depth, radius)
    valid = depth > 0
    centre = np.where(valid, depth, 1)[..., None]
    away = windows - centre
    weight = np.maximum(1 - (away / (3 * depth_sigma)) ** 2, 0) ** 2
    weight[~valid] = 1
    return np.where(valid, centre[..., 0] + (weight * away).sum(-1) / weight.sum(-1), 0).astype(np.float32)


def median3(depth):
    """Median of the valid pixels of each 3 x 3 window (h, w) float32; 0 where the pixel itself has none."""
    windows = _windows(depth, 1)
    ordered = np.sort(np.where(windows > 0, windows, np.inf), axis=-1)
    middle = (windows > 0).sum(-1) // 2
    picked = np.take_along_axis(ordered, np.minimum(middle, 8)[..., None], -1)[..., 0]
    return np.where(depth > 0, picked, 0).astype(np.float32)


def normals(depth, fx, fy, cx, cy, step, jump):
    """Unit normals towards the camera (h, w, 3) float32 from differences over +-step pixels; 0 at edges and jumps."""
    h, w = depth.shape
    z = np.where(depth > 0, depth, np.nan).astype(np.float64)
    y, x = np.mgrid[:h, :w]
    points = np.stack([(x - cx) / fx * z, (y - cy) / fy * z, z], -1)
    out = np.zeros((h, w, 3), np.float32)
    middle = (slice(step, h - step), slice(step, w - step))
    left, right = points[step : h - step, : w - 2 * step], points[step : h - step, 2 * step :]
    up, down = points[: h - 2 * step, step : w - step], points[2 * step :, step : w - step]
    cross = np.cross(down - up, right - left)
    steps = np.stack([left, right, up, down])[..., 2] - points[middle][..., 2]
    length = np.linalg.norm(cross, axis=-1)
    good = (np.abs(steps).max(0) <= jump) & (length > 0)
    out[middle][good] = cross[good] / length[good][:, None]
    return out


def register_depth(depth, source, rotation, translation, target, height, width):
    """Depth (h, w) float32 of one camera as another sees it, (height, width) float32; the nearest wins, 0 = none."""
    v, u = np.nonzero(depth > 0)
    d = depth[v, u].astype(float)
    points = np.stack([(u - source[2]) / source[0] * d, (v - source[3]) / source[1] * d, d], 1)
    x, y, z = (points @ rotation.T + translation).T
    half = 0.5 * max(target[0] / source[0], 1.0)
    out = np.full((height, width), np.inf)
    reach = int(np.ceil(half)) + 1
    a0, b0 = target[0] * x / z + target[2], target[1] * y / z + target[3]
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            a, b = np.floor(a0).astype(int) + dx, np.floor(b0).astype(int) + dy
            good = (z > 1) & (np.abs(a - a0) <= half) & (np.abs(b - b0) <= half)
            good &= (a >= 0) & (b >= 0) & (a < width) & (b < height)
            np.minimum.at(out, (b[good], a[good]), z[good])
    return np.where(np.isfinite(out), out, 0).astype(np.float32)
