"""`soft_shadow` in numpy."""

import numpy as np

from .shade_twin import unit


def soft_shadow(points, normals, lamp, depth, pose, lens):
    """As `mien._kernels.soft_shadow.soft_shadow`."""
    focal, centre, ramp = lens
    n, size = unit(normals), len(depth)
    cosine = n @ lamp
    x, y, z = pose[:, :3] @ points.T.astype(float) + pose[:, 3:]
    texel = z / focal
    slope_u, slope_v, _ = texel / np.maximum(cosine, 0.1) * (pose[:, :3] @ n.T)
    u, v = (np.clip(focal * w / z + centre, 3, size - 4.001) for w in (x, y))
    near = np.arange(-3, 5)
    a, b = u.astype(int)[:, None, None] + near, v.astype(int)[:, None, None] + near[:, None]
    across, down = a - u[:, None, None], b - v[:, None, None]
    plane = (z - texel)[:, None, None] + slope_u[:, None, None] * across + slope_v[:, None, None] * down
    lit = np.clip(1 - (plane - depth[b, a]) / ramp, 0, 1)
    some = lit[:, ::2, ::2]
    agree = np.ptp(some, axis=(1, 2)) <= 0.01
    share = np.where(agree, some.mean((1, 2)), (lit * _spline(across) * _spline(down)).sum((1, 2)))
    return np.where(cosine > 0, share, 0).astype(np.float32)


def _spline(x):
    t = np.abs(x) / 2
    return (np.maximum(2 - t, 0) ** 3 - 4 * np.maximum(1 - t, 0) ** 3) / 12
