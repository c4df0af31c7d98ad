"""The same as `raster`, in plain numpy."""

import numpy as np


def scan_convert(places, faces, owner, barycentric):
    """See `raster.scan_convert`."""
    y, x = np.mgrid[: owner.shape[0], : owner.shape[1]]
    for f, (a, b, c) in enumerate(places[faces]):
        area = np.linalg.det(np.array([b - a, c - a]))
        if area == 0 or not np.isfinite(area):
            continue
        solved = np.linalg.solve(np.array([b - a, c - a]).T, np.stack([x - a[0], y - a[1]]).reshape(2, -1))
        beta, gamma = solved.reshape(2, *owner.shape)
        weights = np.stack([1 - beta - gamma, beta, gamma], -1)
        inside = (weights.min(-1) >= -1e-9) & (owner < 0)
        owner[inside], barycentric[inside] = f, weights[inside]
