"""Depth images: cleaning, normals. A pixel counts where depth > 0, which is false for 0 and for NaN alike."""

from typing import no_type_check

import numba
import numpy as np


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz", "arcp"})
def bilateral(depth, radius, depth_sigma):
    """Edge-keeping smoothing (h, w) float32: box in space, (1 - (dz / 3 sigma)^2)^2 in depth; 0 where none is.

    The innermost loop runs along a row without branches, so that it is done eight pixels at a time.
    """
    h, w = depth.shape
    one, zero = np.float32(1), np.float32(0)
    scale = np.float32(1.0 / (9.0 * depth_sigma * depth_sigma))
    padded = np.zeros((h + 2 * radius, w + 2 * radius), np.float32)
    for i in range(h):
        for j in range(w):
            padded[i + radius, j + radius] = depth[i, j] if depth[i, j] > 0 else zero
    out = np.empty((h, w), np.float32)
    total, weight = np.empty(w, np.float32), np.empty(w, np.float32)
    for i in range(h):
        centre = padded[i + radius, radius : radius + w]
        total[:] = zero
        weight[:] = zero
        for a in range(2 * radius + 1):
            for b in range(2 * radius + 1):
                other = padded[i + a, b : b + w]
                for j in range(w):
                    away = other[j] - centre[j]
                    near = max(one - away * away * scale, zero)
                    total[j] += near * near * away
                    weight[j] += near * near
        for j in range(w):
            out[i, j] = centre[j] + total[j] / weight[j] if centre[j] > 0 else zero
    return out


@no_type_check
@numba.njit(cache=True, nogil=True)
def median3(depth):
    """Median of the valid pixels of each 3 x 3 window (h, w) float32; 0 where the pixel itself has none."""
    h, w = depth.shape
    out = np.zeros((h, w), np.float32)
    window = np.empty(9, np.float32)
    for i in range(h):
        for j in range(w):
            if not depth[i, j] > 0:
                continue
            n = 0
            for a in range(max(i - 1, 0), min(i + 2, h)):
                for b in range(max(j - 1, 0), min(j + 2, w)):
                    value = depth[a, b]
                    if value > 0:
                        k = n
                        while k > 0 and window[k - 1] > value:
                            window[k] = window[k - 1]
                            k -= 1
                        window[k] = value
                        n += 1
            out[i, j] = window[n // 2]
    return out


@no_type_check
@numba.njit(cache=True, nogil=True)
def normals(depth, fx, fy, cx, cy, step, jump):
    """Unit normals towards the camera (h, w, 3) float32 from differences over +-step pixels; 0 at edges and jumps."""
    h, w = depth.shape
    out = np.zeros((h, w, 3), np.float32)
    for i in range(step, h - step):
        for j in range(step, w - step):
            left, right = depth[i, j - step], depth[i, j + step]
            up, down = depth[i - step, j], depth[i + step, j]
            here = depth[i, j]
            if not (here > 0 and left > 0 and right > 0 and up > 0 and down > 0):
                continue
            if max(abs(left - here), abs(right - here), abs(up - here), abs(down - here)) > jump:
                continue
            x, y = (j - cx) / fx, (i - cy) / fy
            s, t = step / fx, step / fy
            ax, ay, az = x * (right - left) + s * (right + left), y * (right - left), right - left
            bx, by, bz = x * (down - up), y * (down - up) + t * (down + up), down - up
            nx, ny, nz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax
            length = np.sqrt(nx * nx + ny * ny + nz * nz)
            if length > 0:
                out[i, j, 0], out[i, j, 1], out[i, j, 2] = nx / length, ny / length, nz / length
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, error_model="numpy")
def register_depth(depth, source, rotation, translation, target, height, width):
    """Depth (h, w) float32 of one camera as another sees it, (height, width) float32; the nearest wins, 0 = none.

    source, target: fx, fy, cx, cy; rotation (3, 3), translation (3,): target from source, mm, float64. Each pixel is
    splatted onto the square that it covers, so that a denser target has no holes.
    """
    out = np.zeros((height, width), np.float32)
    half = 0.5 * max(target[0] / source[0], 1.0)
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            d = depth[i, j]
            if not d > 0:
                continue
            x, y = (j - source[2]) / source[0] * d, (i - source[3]) / source[1] * d
            z = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2] * d + translation[2]
            if z <= 1:
                continue
            px = rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2] * d + translation[0]
            py = rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2] * d + translation[1]
            u, v = target[0] * px / z + target[2], target[1] * py / z + target[3]
            for b in range(max(int(np.ceil(v - half)), 0), min(int(np.floor(v + half)), height - 1) + 1):
                for a in range(max(int(np.ceil(u - half)), 0), min(int(np.floor(u + half)), width - 1) + 1):
                    if out[b, a] == 0 or z < out[b, a]:
                        out[b, a] = z
    return out
