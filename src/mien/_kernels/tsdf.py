"""A truncated signed distance volume that depth images are averaged into (Curless and Levoy 1996)."""

from typing import no_type_check

import numba
import numpy as np


@no_type_check
@numba.njit(cache=True, nogil=True, error_model="numpy")
def integrate(distance, weight, origin, voxel, rotation, translation, depth, intrinsics, truncation, most):
    """Average one depth image into the volume, in place.

    Args:
        distance, weight: (x, y, z) float32; distances are positive in front of the surface, in truncations.
        origin: (3,) float64, centre of voxel 0, 0, 0, mm; voxel: its side, mm.
        rotation (3, 3), translation (3,): camera from volume, float64.
        depth: (h, w) float32, mm, 0 or NaN = none; intrinsics: fx, fy, cx, cy, float64.
        truncation: mm; voxels farther behind the surface are left alone.
        most: weight is not counted beyond this.
    """
    nx, ny, nz = distance.shape
    h, w = depth.shape
    fx, fy, cx, cy = intrinsics
    for i in range(nx):
        for j in range(ny):
            x, y = origin[0] + i * voxel, origin[1] + j * voxel
            px = rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2] * origin[2] + translation[0]
            py = rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2] * origin[2] + translation[1]
            pz = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2] * origin[2] + translation[2]
            for k in range(nz):
                step = k * voxel
                z = pz + rotation[2, 2] * step
                if z <= 1:
                    continue
                u = int(np.floor(fx * (px + rotation[0, 2] * step) / z + cx + 0.5))
                v = int(np.floor(fy * (py + rotation[1, 2] * step) / z + cy + 0.5))
                if u < 0 or v < 0 or u >= w or v >= h:
                    continue
                seen = depth[v, u]
                if not seen > 0:
                    continue
                away = (seen - z) / truncation
                if away < -1:
                    continue
                before = weight[i, j, k]
                distance[i, j, k] = (before * distance[i, j, k] + min(away, 1.0)) / (before + 1)
                weight[i, j, k] = min(before + 1, most)
