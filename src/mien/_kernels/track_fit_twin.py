"""Numpy twins of `track_fit`."""

import numpy as np


def blend(neutral, order, columns, values, weights):
    """neutral + sum of the shapes times `weights` (k,), (n, 3)."""
    return neutral + dense(order, columns, values, len(neutral), len(weights)) @ weights


def dense(order, columns, values, n, k):
    """The basis (n, 3, k) that is packed in blocks."""
    basis = np.zeros((n, 3, k))
    for block, shapes, packed in zip(order, columns, values, strict=True):
        vertices, there = block[block >= 0], shapes[shapes >= 0]
        some = packed[:, : len(there), : len(vertices)].transpose(2, 0, 1)
        basis[vertices[:, None, None], np.arange(3)[None, :, None], there[None, None, :]] = some
    return basis


def plane_system(order, columns, values, k, rotation, points, found, plane, weight, share, centre, scale, lever):
    """Normal equations of the point-to-plane term (Li et al. 2013, eq. 1): A, b, mean |r|, sum of the shares."""
    keep = weight > 0
    n, p = plane[keep].astype(float), points[keep].astype(float)
    r = (n * (found[keep] - p)).sum(1)
    root = np.sqrt(weight[keep] * share[keep]) / (1 + (r / scale) ** 2)
    shapes = np.einsum("id,idk->ik", n @ rotation, dense(order, columns, values, len(points), k)[keep])
    rows = root[:, None] * np.concatenate([shapes, np.cross(p - centre, n) / lever, n], 1)
    error = np.abs(r).mean() if keep.any() else 0.0
    return rows.T @ rows, rows.T @ (root * r), error, share[keep].sum()


def landmark_rows(neutral, basis, weights, rotation, translation, centre, lever):
    """Landmarks in camera space (j, 3) and their derivatives J (j, 3, k + 6)."""
    points = (neutral + basis @ weights) @ rotation.T + translation
    turn = np.stack([np.cross(axis, points - centre) for axis in np.eye(3)], 2) / lever
    shift = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    return np.concatenate([rotation @ basis, turn, shift], 2), points
