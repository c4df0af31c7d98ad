"""The same as `curvature`, in plain numpy: slow, and what the tests hold the kernel against."""

import numpy as np

from .curvature import LEAST


def _gather(centre, radius, vertices, starts, neighbours):
    found, ring = [centre], [centre]
    while ring:
        grown = []
        for i in ring:
            for j in neighbours[starts[i] : starts[i + 1]]:
                near = np.linalg.norm(vertices[j] - vertices[centre]) <= radius
                if j not in found and (near or len(found) <= LEAST):
                    found.append(j)
                    grown.append(j)
        ring = grown
    return found


def patch_curvature(vertices, normals, starts, neighbours, radius):
    """See `curvature.patch_curvature`."""
    result = np.zeros(len(vertices))
    for i, normal in enumerate(normals):
        found = _gather(i, radius, vertices, starts, neighbours)
        frame = np.linalg.svd(normal[None])[2]
        x, y = ((vertices[found] - vertices[i]) @ frame[1:].T).T
        z = (vertices[found] - vertices[i]) @ normal
        terms = np.stack([np.ones_like(x), x, y, x * x / 2, x * y, y * y / 2], 1)
        if len(found) <= 6 or np.linalg.matrix_rank(terms) < 6:
            continue
        _, p, q, a, b, c = np.linalg.lstsq(terms, z, rcond=None)[0]
        result[i] = -((1 + q * q) * a - 2 * p * q * b + (1 + p * p) * c) / (2 * (1 + p * p + q * q) ** 1.5)
    return result
