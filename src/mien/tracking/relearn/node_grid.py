"""A grid of nodes over a picture: what lives there is smooth over some pixels, and solved for node by node."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from jaxtyping import Bool, Float, Float32
from scipy.ndimage import gaussian_filter, map_coordinates

LOOSE = 1e-9
"""Added to each unknown's own weight, so that one of which nothing is known is 0."""
TOLERANCE, MOST = 1e-3, 200
"""Conjugate gradients stop where what is left falls to this share, or after so many steps."""


@dataclass(frozen=True)
class NodeGrid:
    """Nodes `node` pixels apart, each in the middle of its cell; those in whose cell nothing is known are left out."""

    shape: tuple[int, int]
    """Of the picture, pixels."""
    node: int
    """Pixels."""
    there: Bool[np.ndarray, "rows columns"]
    """Which nodes there are, n in all."""
    neighbours: sp.csr_matrix
    """1 where two nodes are next to each other, (n, n)."""

    def summed(self, images: Float[np.ndarray, "c h w"]) -> Float[np.ndarray, "n c"]:
        """Sums over the nodes' cells."""
        return _cells(images, self.node)[:, self.there].T.astype(np.float64)

    def between(self, values: Float[np.ndarray, "n c"]) -> Float32[np.ndarray, "c h w"]:
        """Values at every pixel, linear between nodes; 0 at nodes that are left out."""
        whole = np.zeros((values.shape[1], *self.there.shape), np.float32)
        whole[:, self.there] = values.T
        rows, columns = (self._place(size) for size in self.shape)
        at = np.meshgrid(rows, columns, indexing="ij")
        return np.stack([map_coordinates(each, at, order=1, mode="nearest") for each in whole])

    def _place(self, size: int) -> Float[np.ndarray, " p"]:
        """Of each row or column of pixels among the nodes."""
        return (np.arange(size) - (self.node - 1) / 2) / self.node

    def pooled(self, values: Float[np.ndarray, "n c"], sigma: float) -> Float[np.ndarray, "n c"]:
        """Gaussian sums over the nodes round about, `sigma` in pixels."""
        whole = np.zeros((values.shape[1], *self.there.shape))
        whole[:, self.there] = values.T
        return gaussian_filter(whole, (0, sigma / self.node, sigma / self.node))[:, self.there].T


def node_grid(known: Bool[np.ndarray, "h w"], node: int) -> NodeGrid:
    """The nodes of a picture of which some is known."""
    there = _cells(known[None].astype(np.int64), node)[0] > 0
    number = np.cumsum(there).reshape(there.shape) - 1
    across = there[:, 1:] & there[:, :-1]
    down = there[1:] & there[:-1]
    one = np.concatenate([number[:, :-1][across], number[:-1][down]])
    other = np.concatenate([number[:, 1:][across], number[1:][down]])
    pairs = sp.coo_matrix((np.ones(len(one)), (one, other)), (int(there.sum()),) * 2)
    return NodeGrid(known.shape, node, there, sp.csr_matrix(pairs + pairs.T))


def _cells(images: np.ndarray, node: int) -> np.ndarray:
    h, w = images.shape[1:]
    rows = np.add.reduceat(images, np.arange(0, h, node), axis=1)
    return np.add.reduceat(rows, np.arange(0, w, node), axis=2)


def solve_smoothly(
    grid: NodeGrid,
    matrix: Float[np.ndarray, "n m m"],
    right: Float[np.ndarray, "n m"],
    start: Float[np.ndarray, "n m"],
    smoothness: float,
    small: float,
) -> Float[np.ndarray, "n m"]:
    """The x that minimises sum_i x_i'A_i x_i - 2 b_i'x_i + small |x_i|^2 + smoothness sum_ij |x_i - x_j|^2.

    j runs over i's neighbours, each pair once; by conjugate gradients, each node's own block for a preconditioner.
    """
    degree = np.asarray(grid.neighbours.sum(axis=1)).ravel()
    stiff = (smoothness * degree + small + LOOSE)[:, None]
    own = matrix + stiff[..., None] * np.eye(matrix.shape[1])
    inverse = np.linalg.inv(own)

    def applied(x: np.ndarray) -> np.ndarray:
        nodes = x.reshape(start.shape)
        return (np.einsum("nij,nj->ni", own, nodes) - smoothness * (grid.neighbours @ nodes)).ravel()

    def preconditioned(x: np.ndarray) -> np.ndarray:
        return np.einsum("nij,nj->ni", inverse, x.reshape(start.shape)).ravel()

    square = (start.size, start.size)
    A = spl.LinearOperator(square, matvec=applied, dtype=np.float64)  # pyright: ignore[reportCallIssue]
    M = spl.LinearOperator(square, matvec=preconditioned, dtype=np.float64)  # pyright: ignore[reportCallIssue]
    found, _ = spl.cg(A, right.ravel(), x0=start.ravel(), rtol=TOLERANCE, maxiter=MOST, M=M)
    return found.reshape(start.shape)
