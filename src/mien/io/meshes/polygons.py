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


def strip_triangles(
    items: Int[np.ndarray, " items"], counts: Int[np.ndarray, " strips"]
) -> Int[np.ndarray, "triangles 3"]:
    """Strips of triangles stored one after another, `counts` items each, where -1 ends a strip and begins the next.

    Every second triangle of a strip is turned, so that all look to one side; those without area vanish.
    """
    ends = np.cumsum(counts)
    broken = np.insert(items, ends, -1)
    at_break = np.flatnonzero(broken < 0)
    begins = np.concatenate([[0], at_break + 1])
    place = np.arange(len(broken))
    within = place - begins[np.searchsorted(begins, place, side="right") - 1]
    a, b, c = broken[:-2], broken[1:-1], broken[2:]
    whole = (a >= 0) & (b >= 0) & (c >= 0) & (a != b) & (b != c) & (a != c)
    odd = (within[: len(a)] % 2 == 1)[:, None]
    triangles = np.where(odd, np.stack([b, a, c], axis=1), np.stack([a, b, c], axis=1))
    return triangles[whole]


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
