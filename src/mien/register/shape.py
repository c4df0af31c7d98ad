"""What a template remembers of its shape: edges, cotangent weights, masses, and how neighbourhoods have turned."""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from ..mesh import cotangent_laplacian, mass
from .residuals import Stencil
from .rigid import nearest_rotations


def make_stencil(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> Stencil:
    """The edges of a mesh and their weights (`cotangent_laplacian`), negative ones cut off at a trace."""
    L = sp.coo_matrix(sp.triu(cotangent_laplacian(vertices, faces), k=1))
    edges = np.stack([L.row, L.col], 1).astype(np.int64)
    weights = np.maximum(np.negative(L.data), 1e-3)
    root = np.sqrt(weights)
    rows = np.arange(len(edges))
    entries = (np.r_[root, -root], (np.r_[rows, rows], edges.T.ravel()))
    incidence = sp.csr_matrix(entries, shape=(len(edges), len(vertices)))
    areas = mass(vertices, faces)
    return Stencil(edges, weights, incidence, np.maximum(areas, 1e-3 * max(float(areas.mean()), 1e-12)))


def local_rotations(
    stencil: Stencil, rest: Float[np.ndarray, "n 3"], current: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3 3"]:
    """How each vertex's neighbourhood has turned from `rest` to `current` (Sorkine and Alexa 2007, eq. 5-6)."""
    i, j = stencil.edges.T
    outer = np.einsum("e,ea,eb->eab", stencil.weights, current[i] - current[j], rest[i] - rest[j]).reshape(-1, 9)
    ends = stencil.edges.T.ravel()
    n = len(rest)
    H = np.stack([np.bincount(ends, np.r_[outer[:, k], outer[:, k]], minlength=n) for k in range(9)], 1)
    return nearest_rotations(H.reshape(-1, 3, 3))[0]


def turned_edges(
    stencil: Stencil, rest: Float[np.ndarray, "n 3"], rotations: Float[np.ndarray, "n 3 3"] | None
) -> Float[np.ndarray, "e 3"]:
    """sqrt(w_ij) (R_i + R_j) / 2 (s_i - s_j): the template's edges turned with their ends; as they are for None."""
    straight = stencil.incidence @ rest
    if rotations is None:
        return straight
    i, j = stencil.edges.T
    return np.einsum("eab,eb->ea", (rotations[i] + rotations[j]) / 2, straight)
