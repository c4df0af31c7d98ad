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

from ._spread import spread

NIL, ONE, TWO, THREE, HALF, SIXTH, TWO_THIRDS, THREE_HALVES = np.array(
    [0, 1, 2, 3, 1 / 2, 1 / 6, 2 / 3, 3 / 2], np.float32
)
"""Constants of 32 bits: a plain 1 would turn the arithmetic around it into 64."""
LIMIT = np.float32(0.5)
"""Largest slope of the flow that turns a gradient: steeper ones are edges of the motion."""
ALONE = 1 << 15
"""Pixels below which one thread is done before others have started."""
_COMPILE = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz", "arcp"}}


@no_type_check
@njit(inline="always")
def _value(t):
    """Weights of the four cubic B-splines round a point at t in 0..1."""
    s = ONE - t
    return (
        s * s * s * SIXTH,
        TWO_THIRDS - t * t * (ONE - t * HALF),
        TWO_THIRDS - s * s * (ONE - s * HALF),
        t * t * t * SIXTH,
    )


@no_type_check
@njit(inline="always")
def _first(t):
    """Their first derivatives."""
    s = ONE - t
    return (-s * s * HALF, t * (t * THREE_HALVES - TWO), -s * (s * THREE_HALVES - TWO), t * t * HALF)


@no_type_check
@njit(inline="always")
def _second(t):
    """Their second derivatives."""
    return (ONE - t, THREE * t - TWO, ONE - THREE * t, t)


@no_type_check
@njit(inline="always")
def _row(plane, k, value, first, second):
    """Four coefficients from entry k on, weighed three ways."""
    a, b, c, d = plane[k], plane[k + np.uint32(1)], plane[k + np.uint32(2)], plane[k + np.uint32(3)]
    f = a * value[0] + b * value[1] + c * value[2] + d * value[3]
    f1 = a * first[0] + b * first[1] + c * first[2] + d * first[3]
    return f, f1, a * second[0] + b * second[1] + c * second[2] + d * second[3]


@no_type_check
@njit(inline="always")
def _mix(weights, a, b, c, d):
    return weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d


def linearise(coefficients, weight, u, v, ou, ov, parity, reference, scales, share, turn, fields, inside):
    """The constancies of one half linearised round a flow: image (x + u, y + v) less reference (x, y), and derivatives.

    coefficients (c, (h + 3) * (w + 3)): cubic B-splines of the moved image, one entry of frame before and two after;
    weight (h, w): how far its pixels hold data; u, v, ou, ov (h + 2, half + 2): flow of this half and the other;
    reference (c, 6, h, half): value, d/dx, d/dy, d2/dx2, d2/dxdy, d2/dy2 of the fixed image; scales (c, 2, h, half):
    factors of the terms of value and of gradient; share: how far the derivatives are the fixed image's own; turn:
    whether the moved image's gradient is turned by the flow's slopes before it is compared, (1 + grad w)' grad J, as
    the gradient of the warped image is. Fills fields (c, 8, h, half) with the differences of value, d/dx, d/dy, then
    with d/dx, d/dy, d2/dx2, d2/dxdy, d2/dy2, all scaled; inside (h, half) with the bilinear weight, 0 off the image.
    """
    given = coefficients, weight, u, v, ou, ov, parity, reference, scales, share, turn, fields, inside
    threads = 1 if weight.size < ALONE else 0
    spread(lambda first, last: _linearise_rows(first, last, *given), len(weight), threads)


@no_type_check
@njit(**_COMPILE)
def _linearise_rows(
    first, last, coefficients, weight, u, v, ou, ov, parity, reference, scales, share, turn, fields, inside
):
    """`linearise` in rows `first` to `last`."""
    h, w = weight.shape
    stride = np.uint32(w + 3)
    keep, limit = ONE - share, LIMIT if turn else NIL
    for y in range(first, last):
        l = (y + parity) & 1
        half = HALF if 0 < y < h - 1 else ONE
        for i in range(inside.shape[1]):
            x = 2 * i + l
            px, py = np.float32(x) + u[y + 1, i + 1], np.float32(y) + v[y + 1, i + 1]
            cx, cy = min(max(px, NIL), np.float32(w - 1)), min(max(py, NIL), np.float32(h - 1))
            ix, iy = np.int32(cx), np.int32(cy)
            tx, ty = cx - np.float32(ix), cy - np.float32(iy)
            jx, jy = min(ix + 1, w - 1), min(iy + 1, h - 1)
            top = weight[iy, ix] + tx * (weight[iy, jx] - weight[iy, ix])
            low = weight[jy, ix] + tx * (weight[jy, jx] - weight[jy, ix])
            inside[y, i] = top + ty * (low - top) if px == cx and py == cy else NIL
            across = HALF if 0 < x < w - 1 else ONE
            ux = min(max((ou[y + 1, i + 1 + l] - ou[y + 1, i + l]) * across, -limit), limit)
            vx = min(max((ov[y + 1, i + 1 + l] - ov[y + 1, i + l]) * across, -limit), limit)
            uy = min(max((ou[y + 2, i + 1] - ou[y, i + 1]) * half, -limit), limit)
            vy = min(max((ov[y + 2, i + 1] - ov[y, i + 1]) * half, -limit), limit)
            bx, dx, ex = _value(tx), _first(tx), _second(tx)
            by, dy, ey = _value(ty), _first(ty), _second(ty)
            k = np.uint32(iy) * stride + np.uint32(ix)
            for c in range(coefficients.shape[0]):
                plane = coefficients[c]
                f0, g0, h0 = _row(plane, k, bx, dx, ex)
                f1, g1, h1 = _row(plane, k + stride, bx, dx, ex)
                f2, g2, h2 = _row(plane, k + stride + stride, bx, dx, ex)
                f3, g3, h3 = _row(plane, k + stride + stride + stride, bx, dx, ex)
                fx, fy = _mix(by, g0, g1, g2, g3), _mix(dy, f0, f1, f2, f3)
                p, q = scales[c, 0, y, i], scales[c, 1, y, i]
                fields[c, 0, y, i] = p * (_mix(by, f0, f1, f2, f3) - reference[c, 0, y, i])
                fields[c, 1, y, i] = q * (fx + ux * fx + vx * fy - reference[c, 1, y, i])
                fields[c, 2, y, i] = q * (fy + uy * fx + vy * fy - reference[c, 2, y, i])
                fields[c, 3, y, i] = p * (keep * fx + share * reference[c, 1, y, i])
                fields[c, 4, y, i] = p * (keep * fy + share * reference[c, 2, y, i])
                fields[c, 5, y, i] = q * (keep * _mix(by, h0, h1, h2, h3) + share * reference[c, 3, y, i])
                fields[c, 6, y, i] = q * (keep * _mix(dy, g0, g1, g2, g3) + share * reference[c, 4, y, i])
                fields[c, 7, y, i] = q * (keep * _mix(ey, f0, f1, f2, f3) + share * reference[c, 5, y, i])


@no_type_check
@njit(parallel=True, **_COMPILE)
def diffusivity(u, v, ou, ov, parity, epsilon, g, energy):
    """Derivative of the smoothness penaliser in the pixels of one half, g (h + 2, half + 2), and its sum a row.

    s^2 = half the squared differences to the four neighbours; g = 1 / sqrt(s^2 + epsilon^2);
    energy (h) = sum of sqrt(s^2 + epsilon^2) - epsilon. `o` marks the other half; the frames hold the border's values.
    """
    h, w = u.shape[0] - 2, u.shape[1] - 2
    for y in prange(h):
        l = (y + parity) & 1
        total = NIL
        for i in range(w):
            p, q = u[y + 1, i + 1], v[y + 1, i + 1]
            ul, ur, uu, ud = ou[y + 1, i + l] - p, ou[y + 1, i + 1 + l] - p, ou[y, i + 1] - p, ou[y + 2, i + 1] - p
            vl, vr, vu, vd = ov[y + 1, i + l] - q, ov[y + 1, i + 1 + l] - q, ov[y, i + 1] - q, ov[y + 2, i + 1] - q
            s = ul * ul + ur * ur + uu * uu + ud * ud + vl * vl + vr * vr + vu * vu + vd * vd
            root = np.sqrt(HALF * s + epsilon * epsilon)
            g[y + 1, i + 1] = ONE / root
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
        total = NIL
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
    share = alpha * HALF
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
