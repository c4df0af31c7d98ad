"""Ways along a mesh's edges."""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int
from scipy.sparse.csgraph import dijkstra

from .mesh import Mesh
from .operators import edge_ends

LEAST_LENGTH = 1e-9
"""Added to each edge's: a sparse graph forgets an edge of length 0."""


def edge_lengths(mesh: Mesh) -> sp.csr_matrix:
    """(n, n): the length of each edge, in one of its two directions."""
    i, j = np.unique(edge_ends(mesh.faces), axis=0).T
    length = np.linalg.norm(mesh.vertices[i] - mesh.vertices[j], axis=1) + LEAST_LENGTH
    return sp.csr_matrix((length, (i, j)), shape=(len(mesh.vertices),) * 2)


def nearest_along_edges(
    mesh: Mesh, seeds: Int[np.ndarray, " k"]
) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Which of the `seeds` (vertices) is the nearest to each vertex along the edges, and how far.

    Below 0 and infinite where no way leads to one.
    """
    far, _, nearest = dijkstra(
        edge_lengths(mesh), directed=False, indices=seeds, min_only=True, return_predecessors=True
    )
    return nearest, far
