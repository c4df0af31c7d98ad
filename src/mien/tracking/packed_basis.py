"""Blendshapes packed for speed: neighbouring vertices in blocks, each with the few shapes that move it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Int, Int32

from .._kernels.track_fit import BLOCK, blend

LEAST = 0.05
"""Millimetres: a shape that moves no vertex of a block farther than this is left out of it. The normal equations cost
the square of the shapes a block: 0.01 keeps 47 of 52 and takes twice as long, and films come out the same."""


@dataclass(frozen=True)
class PackedBasis:
    """A basis (n, 3, k), as `mien._kernels.track_fit` takes it."""

    order: Int32[np.ndarray, "blocks 64"]
    """Vertices, -1 where a block is not full."""
    columns: Int32[np.ndarray, "blocks w"]
    """Shapes that move them, ascending, -1 after the last."""
    values: Float32[np.ndarray, "blocks 3 w 64"]
    """What they do, mm."""

    def blend(
        self, neutral: Float32[np.ndarray, "n 3"], weights: Float[np.ndarray, " k"]
    ) -> Float32[np.ndarray, "n 3"]:
        """Neutral plus shapes."""
        return blend(neutral, self.order, self.columns, self.values, np.ascontiguousarray(weights, dtype=np.float64))


def pack(points: Float[np.ndarray, "n 3"], basis: Float[np.ndarray, "n 3 k"]) -> PackedBasis:
    """Cut the vertices into blocks, by halving the longest side of the box round them, and pack each one's shapes."""
    moves = np.linalg.norm(basis, axis=1) > LEAST
    blocks = _halved(points, np.arange(len(points)))
    shapes = [np.flatnonzero(moves[block].any(0)) for block in blocks]
    width = max((len(s) for s in shapes), default=0)
    order = np.full((len(blocks), BLOCK), -1, np.int32)
    columns = np.full((len(blocks), max(width, 1)), -1, np.int32)
    values = np.zeros((len(blocks), 3, columns.shape[1], BLOCK), np.float32)
    for b, (block, some) in enumerate(zip(blocks, shapes, strict=True)):
        order[b, : len(block)], columns[b, : len(some)] = block, some
        values[b, :, : len(some), : len(block)] = basis[block][:, :, some].transpose(1, 2, 0)
    return PackedBasis(order, columns, values)


def _halved(points: np.ndarray, members: Int[np.ndarray, " m"]) -> list[np.ndarray]:
    """Blocks of at most BLOCK vertices, all but the last of each half full."""
    if len(members) <= BLOCK:
        return [members]
    side = int(np.ptp(points[members], axis=0).argmax())
    along = members[np.argsort(points[members, side], kind="stable")]
    half = BLOCK * max(round(len(members) / BLOCK / 2), 1)
    return _halved(points, along[:half]) + _halved(points, along[half:])
