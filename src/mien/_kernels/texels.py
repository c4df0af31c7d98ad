"""Displacements of a training skin from the base motion, at every texel of a map."""

from typing import no_type_check

import numba as nb
import numpy as np


@no_type_check
@nb.njit(cache=True, nogil=True, inline="always")
def _mixed(values, corners, weights, p, row, out):
    """out (3,) = vertex vectors `values` (n, r, 3), their row `row`, at texel p."""
    a, b, c = corners[p, 0], corners[p, 1], corners[p, 2]
    for d in range(3):
        out[d] = (
            weights[p, 0] * values[a, row, d] + weights[p, 1] * values[b, row, d] + weights[p, 2] * values[c, row, d]
        )


@no_type_check
@nb.njit(cache=True, nogil=True, inline="always")
def _unit(v):
    length = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    for d in range(3):
        v[d] /= length


@no_type_check
@nb.njit(cache=True, nogil=True, error_model="numpy")
def displacements(base, frames, at_corners, at_weights, skin, on_corners, on_weights, farthest, out):
    """out (p, 3): skin minus base in the base's local frame (u, v, n); NaN beyond `farthest`, or where skin is NaN.

    base (n, 3) and skin (m, 3) vertices; frames (n, 3, 3), rows u, v, n; corners (p, 3) vertices of each texel's
    triangle on the base (`at`) and on the skin (`on`), weights (p, 3) barycentric. Interpolated frames are made
    orthonormal, the normal's direction kept.
    """
    base, skin = base.reshape(-1, 1, 3), skin.reshape(-1, 1, 3)
    here, there, normal, u = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for p in range(out.shape[0]):
        _mixed(skin, on_corners, on_weights, p, 0, there)
        _mixed(base, at_corners, at_weights, p, 0, here)
        _mixed(frames, at_corners, at_weights, p, 0, u)
        _mixed(frames, at_corners, at_weights, p, 2, normal)
        _unit(normal)
        along = u[0] * normal[0] + u[1] * normal[1] + u[2] * normal[2]
        for d in range(3):
            u[d] -= along * normal[d]
        _unit(u)
        x, y, z = there[0] - here[0], there[1] - here[1], there[2] - here[2]
        if not x * x + y * y + z * z <= farthest * farthest:
            out[p] = np.nan
            continue
        out[p, 0] = x * u[0] + y * u[1] + z * u[2]
        out[p, 1] = (
            x * (normal[1] * u[2] - normal[2] * u[1])
            + y * (normal[2] * u[0] - normal[0] * u[2])
            + z * (normal[0] * u[1] - normal[1] * u[0])
        )
        out[p, 2] = x * normal[0] + y * normal[1] + z * normal[2]
