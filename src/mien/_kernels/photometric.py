"""Photometric stereo, pixel by pixel: a reweighted 3 x 3 system each, solved in closed form."""

from typing import no_type_check

import numba as nb

FLOOR = 1e-9
"""Of a system's trace, added to its diagonal: lamps in one plane leave it singular."""


@no_type_check
@nb.njit(cache=True, nogil=True, inline="always")
def _solved(a, b, c, d, e, f, x, y, z):
    """Of the symmetric system [[a, b, c], [b, d, e], [c, e, f]]."""
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * A + b * B + c * C
    D, E, F = a * f - c * c, b * c - a * e, a * d - b * b
    return (
        (A * x + B * y + C * z) / determinant,
        (B * x + D * y + E * z) / determinant,
        (C * x + E * y + F * z) / determinant,
    )


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def robust_normals(values, light, usable, scales, rounds, normals, weights):
    """min over n of sum_k rho((values_k - light_k . n) / scale), Cauchy's rho, by reweighted least squares.

    values, usable (p, k); light (p, k, 3); scales (p,), of residuals that still count; normals (p, 3) times albedo and
    weights (p, k), 0..1, are written.
    """
    for p in range(values.shape[0]):
        x, y, z = 0.0, 0.0, 0.0
        for k in range(values.shape[1]):
            weights[p, k] = 1.0 if usable[p, k] else 0.0
        for _ in range(rounds):
            a, b, c, d, e, f = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            u, v, w = 0.0, 0.0, 0.0
            for k in range(values.shape[1]):
                weight = weights[p, k]
                lx, ly, lz = light[p, k, 0], light[p, k, 1], light[p, k, 2]
                a += weight * lx * lx
                b += weight * lx * ly
                c += weight * lx * lz
                d += weight * ly * ly
                e += weight * ly * lz
                f += weight * lz * lz
                u += weight * lx * values[p, k]
                v += weight * ly * values[p, k]
                w += weight * lz * values[p, k]
            floor = FLOOR * (a + d + f) + 1e-30
            x, y, z = _solved(a + floor, b, c, d + floor, e, f + floor, u, v, w)
            for k in range(values.shape[1]):
                off = (values[p, k] - light[p, k, 0] * x - light[p, k, 1] * y - light[p, k, 2] * z) / scales[p]
                weights[p, k] = 1.0 / (1.0 + off * off) if usable[p, k] else 0.0
        normals[p, 0], normals[p, 1], normals[p, 2] = x, y, z
