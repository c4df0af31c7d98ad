"""Polygons to triangles, doubled vertices to one: what mesh files need that `Mesh` does not hold."""

import numpy as np
from jaxtyping import Float, Int


def fan(counts: Int[np.ndarray, " polygons"]) -> Int[np.ndarray, "m 3"]:
    """Polygons stored corner after corner, `counts` corners each -> triangles, as places in that list of corners.

    Each polygon becomes a fan about its first corner. Those of fewer than three corners vanish.
    """
    counts = np.asarray(counts, np.int64)
    start = np.cumsum(counts) - counts
    triangles = np.maximum(counts - 2, 0)
    first = np.repeat(start, triangles)
    step = np.arange(len(first)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([first, first + step + 1, first + step + 2], axis=1)


def weld(columns: Float[np.ndarray, "s width"]) -> Int[np.ndarray, " s"]:
    """For each row its place once equal rows (in float32) are one, in first-met order."""
    rows = np.ascontiguousarray(columns.astype(np.float32) + np.float32(0)).view(np.uint32)
    multipliers = np.random.default_rng(0).integers(0, 2**64, rows.shape[1], dtype=np.uint64, endpoint=False) | 1
    hashes = (rows * multipliers).sum(axis=1, dtype=np.uint64)
    _, first, which = np.unique(hashes, return_index=True, return_inverse=True)
    if not np.array_equal(rows[first][which], rows):
        _, first, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[which.reshape(-1)]
