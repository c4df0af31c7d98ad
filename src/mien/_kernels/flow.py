"""Hot loops of the variational optical flow, on checkerboard halves.

An image (h, w) of even width is kept as its red and black pixels, (2, h, half = w / 2): pixel (x, y) is entry
[(x + y) % 2, y, x // 2].
The four neighbours of a red pixel are black, so that one half is updated from the other in straight runs of memory.
Flow halves have a frame of one entry all round, (h + 2, half + 2). Every function has a numpy twin in `flow_twin`.

The arrays given to one call must not share memory: the compiler counts on it.
"""

from typing import no_type_check

import numpy as np
from numba import njit, prange

LIMIT = np.float32(0.5)
"""Largest slope of the flow that turns a gradient: steeper ones are edges of the motion."""
_COMPILE = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz", "arcp"}}


@no_type_check
@njit(**_COMPILE)
def _basis(t, out):
    """Weights of the four cubic B-splines around a point at t in 0..1: value, first and second derivative."""
    s = 1 - t
    out[0, 0], out[0, 3] = s * s * s / 6, t * t * t / 6
    out[0, 1], out[0, 2] = 2 / 3 - t * t * (1 - t / 2), 2 / 3 - s * s * (1 - s / 2)
    out[1, 0], out[1, 3] = -s * s / 2, t * t / 2
    out[1, 1], out[1, 2] = t * (3 * t / 2 - 2), -s * (3 * s / 2 - 2)
    out[2, 0], out[2, 1], out[2, 2], out[2, 3] = s, 3 * t - 2, 3 * s - 2, t


@no_type_check
@njit(**_COMPILE)
def _spline(coefficients, ix, iy, c, bx, by):
    """Value, d/dx, d/dy, d2/dx2, d2/dxdy, d2/dy2 of channel c, from 4 x 4 coefficients."""
    f = f10 = f01 = f20 = f11 = f02 = np.float32(0)
    for j in range(4):
        a = b = d = np.float32(0)
        for m in range(4):
            value = coefficients[iy + j, ix + m, c]
            a += value * bx[0, m]
            b += value * bx[1, m]
            d += value * bx[2, m]
        f += by[0, j] * a
        f10 += by[0, j] * b
        f01 += by[1, j] * a
        f20 += by[0, j] * d
        f11 += by[1, j] * b
        f02 += by[2, j] * a
    return f, f10, f01, f20, f11, f02


@no_type_check
@njit(**_COMPILE)
def _slopes(u, k, x, y, w, h):
    """Differences of a flow component along x and y at a pixel: central, one-sided at the border; at most LIMIT."""
    i, row, l = x >> 1, y + 1, x & 1
    other = u[1 - k]
    across = (other[row, i + 1 + l] - other[row, i + l]) * (np.float32(0.5) if 0 < x < w - 1 else np.float32(1))
    down = (other[row + 1, i + 1] - other[row - 1, i + 1]) * (np.float32(0.5) if 0 < y < h - 1 else np.float32(1))
    return min(max(across, -LIMIT), LIMIT), min(max(down, -LIMIT), LIMIT)


@no_type_check
@njit(parallel=True, **_COMPILE)
def linearise(coefficients, weight, u, v, reference, scales, share, turn, fields, inside):
    """The constancies linearised round a flow: image (x + u, y + v) less reference (x, y), and its derivatives.

    coefficients (h + 3, w + 3, c): cubic B-splines of the moved image, one entry of frame before and two after;
    weight (h, w): how far its pixels hold data; u, v (2, h + 2, half + 2); reference (2, c, 6, h, half): value, d/dx,
    d/dy, d2/dx2, d2/dxdy, d2/dy2 of the fixed image; scales (2, c, 2, h, half): factors of the terms of value and of
    gradient; share: how far the derivatives are the fixed image's own; turn: whether the moved image's gradient is
    turned by the flow's slopes before it is compared, (1 + grad w)' grad J, as the gradient of the warped image is.
    Fills fields (2, c, 8, h, half) with the differences of value, d/dx, d/dy, then with d/dx, d/dy, d2/dx2, d2/dxdy,
    d2/dy2, all scaled; and inside (2, h, half) with the bilinear weight, 0 outside the image.
    """
    h, w = weight.shape
    keep = np.float32(1) - share
    for y in prange(h):
        bx, by = np.empty((3, 4), np.float32), np.empty((3, 4), np.float32)
        for x in range(w):
            k, i = (x + y) & 1, x >> 1
            px, py = np.float32(x) + u[k, y + 1, i + 1], np.float32(y) + v[k, y + 1, i + 1]
            cx = min(max(px, np.float32(0)), np.float32(w - 1))
            cy = min(max(py, np.float32(0)), np.float32(h - 1))
            ix, iy = int(cx), int(cy)
            fx, fy = cx - np.float32(ix), cy - np.float32(iy)
            jx, jy = min(ix + 1, w - 1), min(iy + 1, h - 1)
            top = weight[iy, ix] + fx * (weight[iy, jx] - weight[iy, ix])
            low = weight[jy, ix] + fx * (weight[jy, jx] - weight[jy, ix])
            inside[k, y, i] = top + fy * (low - top) if px == cx and py == cy else np.float32(0)
            _basis(fx, bx)
            _basis(fy, by)
            ux = uy = vx = vy = np.float32(0)
            if turn:
                ux, uy = _slopes(u, k, x, y, w, h)
                vx, vy = _slopes(v, k, x, y, w, h)
            for c in range(coefficients.shape[2]):
                f, f10, f01, f20, f11, f02 = _spline(coefficients, ix, iy, c, bx, by)
                p, q = scales[k, c, 0, y, i], scales[k, c, 1, y, i]
                fields[k, c, 0, y, i] = p * (f - reference[k, c, 0, y, i])
                fields[k, c, 1, y, i] = q * (f10 + ux * f10 + vx * f01 - reference[k, c, 1, y, i])
                fields[k, c, 2, y, i] = q * (f01 + uy * f10 + vy * f01 - reference[k, c, 2, y, i])
                fields[k, c, 3, y, i] = p * (keep * f10 + share * reference[k, c, 1, y, i])
                fields[k, c, 4, y, i] = p * (keep * f01 + share * reference[k, c, 2, y, i])
                fields[k, c, 5, y, i] = q * (keep * f20 + share * reference[k, c, 3, y, i])
                fields[k, c, 6, y, i] = q * (keep * f11 + share * reference[k, c, 4, y, i])
                fields[k, c, 7, y, i] = q * (keep * f02 + share * reference[k, c, 5, y, i])


@no_type_check
@njit(parallel=True, **_COMPILE)
def diffusivity(u, v, ou, ov, parity, epsilon, g, energy):
    """Derivative of the smoothness penaliser in the pixels of one half, g (h + 2, half + 2), and its sum a row.

    s^2 = half the squared differences to the four neighbours; g = 1 / sqrt(s^2 + epsilon^2);
    energy (h) = sum of sqrt(s^2 + epsilon^2) - epsilon. `o` marks the other half; the frames hold the border's values.
    """
    h, w = u.shape[0] - 2, u.shape[1] - 2
    half = np.float32(0.5)
    for y in prange(h):
        l = (y + parity) & 1
        total = np.float32(0)
        for i in range(w):
            p, q = u[y + 1, i + 1], v[y + 1, i + 1]
            ul, ur, uu, ud = ou[y + 1, i + l] - p, ou[y + 1, i + 1 + l] - p, ou[y, i + 1] - p, ou[y + 2, i + 1] - p
            vl, vr, vu, vd = ov[y + 1, i + l] - q, ov[y + 1, i + 1 + l] - q, ov[y, i + 1] - q, ov[y + 2, i + 1] - q
            s = ul * ul + ur * ur + uu * uu + ud * ud + vl * vl + vr * vr + vu * vu + vd * vd
            root = np.sqrt(half * s + epsilon * epsilon)
            g[y + 1, i + 1] = 1 / root
            total += root - epsilon
        energy[y] = total


@no_type_check
@njit(parallel=True, **_COMPILE)
def data_terms(fields, inside, held, u, v, u0, v0, beta, gamma, epsilon, a11, a12, a22, b1, b2, energy):
    """The quadratic that bounds the data term of one half from above at u, v (lagged nonlinearity), and its sum a row.

    fields (c, 8, h, half): from `linearise` at the flow u0, v0 (h, half); inside (h, half): weight of the pixels; held
    (5, h, half): what constraints add to a11, a12, a22, b1, b2; beta, gamma: weights of value and gradient, each term
    with the penaliser sqrt(s^2 + epsilon^2) - epsilon of its own. Fills a11 .. b2 (h, half), with which the minimum
    obeys a (u, v) = b where there is no smoothness, and energy (h).
    """
    channels, _, h, w = fields.shape
    for y in prange(h):
        total = np.float32(0)
        for i in range(w):
            a11[y, i], a12[y, i], a22[y, i] = held[0, y, i], held[1, y, i], held[2, y, i]
            b1[y, i], b2[y, i] = held[3, y, i], held[4, y, i]
        for c in range(channels):
            for i in range(w):
                x, z = u[y + 1, i + 1], v[y + 1, i + 1]
                dx, dz = x - u0[y, i], z - v0[y, i]
                fx, fy = fields[c, 3, y, i], fields[c, 4, y, i]
                fxx, fxy, fyy = fields[c, 5, y, i], fields[c, 6, y, i], fields[c, 7, y, i]
                r = fields[c, 0, y, i] + fx * dx + fy * dz
                rx = fields[c, 1, y, i] + fxx * dx + fxy * dz
                ry = fields[c, 2, y, i] + fxy * dx + fyy * dz
                root = np.sqrt(r * r + epsilon * epsilon)
                roots = np.sqrt(rx * rx + ry * ry + epsilon * epsilon)
                p, q = beta * inside[y, i] / root, gamma * inside[y, i] / roots
                m11 = p * fx * fx + q * (fxx * fxx + fxy * fxy)
                m12 = p * fx * fy + q * (fxx * fxy + fxy * fyy)
                m22 = p * fy * fy + q * (fxy * fxy + fyy * fyy)
                a11[y, i] += m11
                a12[y, i] += m12
                a22[y, i] += m22
                b1[y, i] += m11 * x + m12 * z - p * fx * r - q * (fxx * rx + fxy * ry)
                b2[y, i] += m12 * x + m22 * z - p * fy * r - q * (fxy * rx + fyy * ry)
                total += inside[y, i] * (beta * (root - epsilon) + gamma * (roots - epsilon))
        energy[y] = total


@no_type_check
@njit(parallel=True, **_COMPILE)
def edge_weights(g, og, parity, alpha, edges):
    """Weights of the smoothness towards the left, right, upper and lower neighbour of one half, edges (4, h, half).

    alpha times the mean `diffusivity` of the two pixels. Those across the image's border are for the caller to clear.
    """
    h, w = edges.shape[1:]
    share = alpha / 2
    for y in prange(h):
        l = (y + parity) & 1
        for i in range(w):
            own = g[y + 1, i + 1]
            edges[0, y, i] = share * (own + og[y + 1, i + l])
            edges[1, y, i] = share * (own + og[y + 1, i + 1 + l])
            edges[2, y, i] = share * (own + og[y, i + 1])
            edges[3, y, i] = share * (own + og[y + 2, i + 1])


@no_type_check
@njit(parallel=True, **_COMPILE)
def relax(u, v, ou, ov, a11, a12, a22, b1, b2, edges, parity, omega):
    """Half a sweep of block over-relaxation: each (u, v) of one half from its four neighbours in the other.

    In its pixel it solves (a + sum of edges) (u, v) = b + edges * neighbours, and goes `omega` times the way there.
    """
    h, w = a11.shape
    for y in prange(h):
        l = (y + parity) & 1
        for i in range(w):
            e0, e1, e2, e3 = edges[0, y, i], edges[1, y, i], edges[2, y, i], edges[3, y, i]
            r1 = e0 * ou[y + 1, i + l] + e1 * ou[y + 1, i + 1 + l] + e2 * ou[y, i + 1] + e3 * ou[y + 2, i + 1]
            r1 += b1[y, i]
            r2 = e0 * ov[y + 1, i + l] + e1 * ov[y + 1, i + 1 + l] + e2 * ov[y, i + 1] + e3 * ov[y + 2, i + 1]
            r2 += b2[y, i]
            total = e0 + e1 + e2 + e3
            d1, d2, d12 = a11[y, i] + total, a22[y, i] + total, a12[y, i]
            scale = omega / (d1 * d2 - d12 * d12)
            u[y + 1, i + 1] += scale * (d2 * r1 - d12 * r2) - omega * u[y + 1, i + 1]
            v[y + 1, i + 1] += scale * (d1 * r2 - d12 * r1) - omega * v[y + 1, i + 1]
