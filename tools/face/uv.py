"""The face's texture layout: the base's charts, turned upright, enlarged and packed into the unit square."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

MARGIN = 0.012
SCALES = {0: 0.9, 1: 6.0, 2: 6.0, 3: 2.0, 4: 2.0, 5: 1.5}
"""Part -> enlargement of its charts beside the head's."""


def pack(uv: np.ndarray, corners: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Charts (u, 2) with quads `corners` (m, 4) of each `part` (m,) -> the same in 0..1.

    The head's chart (the one of most quads) stands upright along the lower edge as seen from the front, the
    subject's left at the right; the others stand in rows above it.
    """
    pairs = np.concatenate([corners[:, [i, (i + 1) % 4]] for i in range(4)])
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(uv), len(uv)))
    _, chart = connected_components(graph, directed=False)
    of_quad = chart[corners[:, 0]]
    head = np.bincount(of_quad).argmax()
    upright = np.stack([uv[:, 1], -uv[:, 0]], 1)
    out = np.zeros_like(uv)
    ids = chart == head
    low, high = upright[ids].min(0), upright[ids].max(0)
    scale = (1 - 2 * MARGIN) / (high[0] - low[0])
    out[ids] = (upright[ids] - low) * scale + MARGIN
    left, base, tallest = MARGIN, out[ids, 1].max() + 2 * MARGIN, 0.0
    sizes = {c: scale * SCALES[int(part[of_quad == c][0])] for c in sorted(set(of_quad) - {head})}
    for c, size in sorted(sizes.items(), key=lambda item: -item[1] * np.ptp(uv[chart == item[0], 1])):
        ids = chart == c
        width, height = np.ptp(uv[ids], axis=0) * size
        if left + width > 1:
            left, base, tallest = MARGIN, base + tallest + MARGIN, 0.0
        out[ids] = (uv[ids] - uv[ids].min(0)) * size + [left, base]
        left, tallest = left + width + MARGIN, max(tallest, height)
    if out.max() > 1 or out.min() < 0:
        raise SystemExit(f"the texture's charts do not fit: they reach {out.max(0)}")
    return out
