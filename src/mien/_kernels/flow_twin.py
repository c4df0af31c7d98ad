"""The same functions as `flow`, in plain numpy: slow, short, and what the tests hold the kernels against."""

import numpy as np

from .flow import LIMIT


def _basis(t):
    s = 1 - t
    zero = [s**3 / 6, 2 / 3 - t**2 * (1 - t / 2), 2 / 3 - s**2 * (1 - s / 2), t**3 / 6]
    one = [-(s**2) / 2, t * (1.5 * t - 2), -s * (1.5 * s - 2), t**2 / 2]
    two = [s, 3 * t - 2, 3 * s - 2, t]
    return np.array([zero, one, two])


def _neighbours(other, parity):
    """Left, right, upper and lower neighbours of one half, out of the framed other half."""
    h = other.shape[0] - 2
    odd = ((np.arange(h) + parity) & 1)[:, None] == 1
    left = np.where(odd, other[1:-1, 1:-1], other[1:-1, :-2])
    right = np.where(odd, other[1:-1, 2:], other[1:-1, 1:-1])
    return np.array([left, right, other[:-2, 1:-1], other[2:, 1:-1]])


def _slopes(other, parity, axis):
    """Differences along an axis (1: x, 0: y) at the pixels of one half, one-sided at the border, clipped."""
    left, right, up, down = _neighbours(other, parity)
    slopes = (right - left) / 2 if axis else (down - up) / 2
    if axis:
        slopes[parity::2, 0] *= 2
        slopes[1 - parity :: 2, -1] *= 2
    else:
        slopes[[0, -1]] *= 2
    return np.clip(slopes, -LIMIT, LIMIT)


def linearise(coefficients, weight, u, v, ou, ov, parity, reference, scales, share, turn, fields, inside):
    """See `flow.linearise`."""
    h, w = weight.shape
    y, i = np.mgrid[:h, : inside.shape[1]]
    px, py = 2 * i + ((y + parity) & 1) + u[1:-1, 1:-1].astype(float), y + v[1:-1, 1:-1].astype(float)
    cx, cy = np.clip(px, 0, w - 1), np.clip(py, 0, h - 1)
    ix, iy = cx.astype(int), cy.astype(int)
    fx, fy = cx - ix, cy - iy
    jx, jy = np.minimum(ix + 1, w - 1), np.minimum(iy + 1, h - 1)
    top = (1 - fx) * weight[iy, ix] + fx * weight[iy, jx]
    low = (1 - fx) * weight[jy, ix] + fx * weight[jy, jx]
    inside[:] = np.where((px == cx) & (py == cy), (1 - fy) * top + fy * low, 0)
    planes = coefficients.reshape(-1, h + 3, w + 3)
    around = np.array([[planes[:, iy + j, ix + m] for m in range(4)] for j in range(4)])
    found = np.einsum("bjyi,amyi,jmcyi->bacyi", _basis(fy), _basis(fx), around)
    value, gx, gy, gxx, gxy, gyy = (found[b, a] for b, a in ((0, 0), (0, 1), (1, 0), (0, 2), (1, 1), (2, 0)))
    ux, vx, uy, vy = (_slopes(o, parity, axis) if turn else 0 for axis in (1, 0) for o in (ou, ov))
    own = np.moveaxis(reference, 1, 0)
    p, q = np.moveaxis(scales, 1, 0)
    turned = gx + ux * gx + vx * gy, gy + uy * gx + vy * gy
    rows = [p * (value - own[0]), q * (turned[0] - own[1]), q * (turned[1] - own[2])]
    mixed = [(1 - share) * found + share * fixed for found, fixed in zip((gx, gy, gxx, gxy, gyy), own[1:], strict=True)]
    rows += [p * mixed[0], p * mixed[1], *(q * m for m in mixed[2:])]
    fields[:] = np.moveaxis(np.array(rows), 0, 1)


def diffusivity(u, v, ou, ov, parity, epsilon, g, energy):
    """See `flow.diffusivity`."""
    squares = sum(((_neighbours(o, parity) - own[1:-1, 1:-1]) ** 2).sum(0) for own, o in ((u, ou), (v, ov)))
    root = np.sqrt(squares / 2 + epsilon**2)
    g[1:-1, 1:-1] = 1 / root
    energy[:] = (root - epsilon).sum(1)


def data_terms(fields, inside, held, u, v, u0, v0, beta, gamma, epsilon, a11, a12, a22, b1, b2, energy):
    """See `flow.data_terms`."""
    flow = np.array([u[1:-1, 1:-1], v[1:-1, 1:-1]])
    step = flow - np.array([u0, v0])
    gradients = np.array([fields[:, [3, 4]], fields[:, [5, 6]], fields[:, [6, 7]]])  # of value, d/dx and d/dy
    residuals = np.moveaxis(fields[:, :3], 1, 0) + np.einsum("tcdyi,dyi->tcyi", gradients, step)
    roots = np.sqrt(np.array([residuals[0] ** 2, (residuals[1:] ** 2).sum(0)]) + epsilon**2)
    weights = inside * np.array([beta, gamma])[:, None, None, None] / roots
    weights = weights[[0, 1, 1]]
    a = np.einsum("tcyi,tcdyi,tceyi->deyi", weights, gradients, gradients)
    b = np.einsum("deyi,eyi->dyi", a, flow) - np.einsum("tcyi,tcdyi,tcyi->dyi", weights, gradients, residuals)
    a11[:], a12[:], a22[:] = held[0] + a[0, 0], held[1] + a[0, 1], held[2] + a[1, 1]
    b1[:], b2[:] = held[3] + b[0], held[4] + b[1]
    energy[:] = (inside * (beta * (roots[0] - epsilon) + gamma * (roots[1] - epsilon))).sum((0, 2))


def edge_weights(g, og, parity, alpha, edges):
    """See `flow.edge_weights`."""
    edges[:] = alpha / 2 * (g[1:-1, 1:-1] + _neighbours(og, parity))


def relax(u, v, ou, ov, a11, a12, a22, b1, b2, edges, parity, omega):
    """See `flow.relax`."""
    r1, r2 = b1 + (edges * _neighbours(ou, parity)).sum(0), b2 + (edges * _neighbours(ov, parity)).sum(0)
    total = edges.sum(0)
    d1, d2 = a11 + total, a22 + total
    determinant = d1 * d2 - a12**2
    u[1:-1, 1:-1] += omega * ((d2 * r1 - a12 * r2) / determinant - u[1:-1, 1:-1])
    v[1:-1, 1:-1] += omega * ((d1 * r2 - a12 * r1) / determinant - v[1:-1, 1:-1])
