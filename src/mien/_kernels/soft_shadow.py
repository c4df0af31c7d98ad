"""Soft shadows from a lamp's depth image. `soft_shadow_twin` has the numpy twin."""

from typing import no_type_check

import numpy as np
from numba import njit

from ._spread import spread
from .shade import unit


def soft_shadow(points, normals, lamp, depth, pose, lens, threads=0):
    """The share of a lamp that arrives at samples, from the depth image that the lamp sees (percentage-closer
    filtering; Reeves et al. 1987).

    The depths of 8 x 8 texels are compared with the sample's tangent plane, so that slopes do not shadow themselves,
    and weighted by a cubic B-spline, so that edges are soft and vary smoothly. Where every other texel of every other
    row says the same, the rest is not asked.

    Args:
        points, normals: (s, 3) float32, camera space; normals of any length.
        lamp: (3,) unit direction towards the lamp.
        depth: (k, k) float32, mm, far where there is nothing.
        pose: (3, 4), camera space -> lamp space.
        lens: focal length and centre of the lamp's square image, pixels; how far (mm) a surface must lie behind
            another to be wholly in its shadow.

    Returns:
        (s,) float32, 0..1.
    """
    points = np.ascontiguousarray(points, dtype=np.float32)
    normals = np.ascontiguousarray(normals, dtype=np.float32)
    lamp, pose = np.array(lamp, dtype=np.float64), np.ascontiguousarray(pose, dtype=np.float64)
    depth, lens = np.ascontiguousarray(depth, dtype=np.float32), np.array(lens, dtype=np.float64)
    out = np.empty(len(points), np.float32)
    spread(lambda a, b: _soft_shadow(points, normals, lamp, depth, pose, lens, a, b, out), len(points), threads)
    return out


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _spline(x):
    """Cubic B-spline over 8 texels, x texels from its middle; over all texels it adds up to one."""
    t = 0.5 * abs(x)
    if t >= 2:
        return 0.0
    outer = 2 - t
    inner = max(1 - t, 0.0)
    return (outer * outer * outer - 4 * inner * inner * inner) / 12


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _lit_share(depth, i, j, u, v, z, slope_u, slope_v, ramp, step):
    """Share of the texels i-3..i+4, j-3..j+4, every `step`-th, that lie no nearer the lamp than the tangent plane;
    weighted if all are asked. And how much they disagree."""
    total, low, high = 0.0, 1.0, 0.0
    for b in range(j - 3, j + 5, step):
        down = _spline(b - v) if step == 1 else 0.25
        for a in range(i - 3, i + 5, step):
            gap = z + slope_u * (a - u) + slope_v * (b - v) - depth[b, a]
            lit = min(max(1 - gap / ramp, 0.0), 1.0)
            low, high = min(low, lit), max(high, lit)
            total += lit * down * (_spline(a - u) if step == 1 else 0.25)
    return total, high - low


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _soft_shadow(points, normals, lamp, depth, pose, lens, first, last, out):
    size, focal, centre, ramp = len(depth), lens[0], lens[1], lens[2]
    for s in range(first, last):
        n = unit(normals[s, 0], normals[s, 1], normals[s, 2])
        cosine = n[0] * lamp[0] + n[1] * lamp[1] + n[2] * lamp[2]
        if cosine <= 0:
            out[s] = 0
            continue
        p = points[s]
        x = pose[0, 0] * p[0] + pose[0, 1] * p[1] + pose[0, 2] * p[2] + pose[0, 3]
        y = pose[1, 0] * p[0] + pose[1, 1] * p[1] + pose[1, 2] * p[2] + pose[1, 3]
        z = pose[2, 0] * p[0] + pose[2, 1] * p[1] + pose[2, 2] * p[2] + pose[2, 3]
        # the tangent plane in the lamp's image: depth per texel, held back where it is nearly edge-on
        texel = z / focal
        steep = texel / max(cosine, 0.1)
        slope_u = steep * (pose[0, 0] * n[0] + pose[0, 1] * n[1] + pose[0, 2] * n[2])
        slope_v = steep * (pose[1, 0] * n[0] + pose[1, 1] * n[1] + pose[1, 2] * n[2])
        u = min(max(focal * x / z + centre, 3.0), size - 4.001)
        v = min(max(focal * y / z + centre, 3.0), size - 4.001)
        i, j = int(u), int(v)
        lit, doubt = _lit_share(depth, i, j, u, v, z - texel, slope_u, slope_v, ramp, 2)
        if doubt > 0.01:
            lit, doubt = _lit_share(depth, i, j, u, v, z - texel, slope_u, slope_v, ramp, 1)
        out[s] = lit
