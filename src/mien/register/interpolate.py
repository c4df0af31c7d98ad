"""Values at a few points of a surface carried over all of it: one bending spline for every use."""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int
from scipy.sparse.linalg import splu

from ..mesh import Attachment, Mesh, cotangent_laplacian, mass

SMALLEST_AREA = 1e-3
"""Least area of a vertex in the bending energy, as a share of the mean one: slivers must not stiffen it."""


def green_functions(
    mesh: Mesh, D: sp.csr_matrix, reach_mm: float, where: Int[np.ndarray, " k"] | None = None
) -> Float[np.ndarray, "n points"]:
    """How the surface moves when one of its points is pulled, a column a point: B^-1 D', B = L'M^-1 L + M / reach^4.

    B is the screened bending energy (Botsch and Sorkine 2008): L the cotangent Laplacian, M the vertex areas.

    Args:
        D: the points, (points, n), as `Attachment.matrix` gives it.
        reach_mm: a pull fades beyond about so far from its point.
        where: vertices that may move, the others stay 0; all by default.
    """
    count = len(mesh.vertices)
    free = np.arange(count) if where is None else where
    pick = sp.csr_matrix((np.ones(len(free)), (np.arange(len(free)), free)), shape=(len(free), count))
    L, area = cotangent_laplacian(mesh.vertices, mesh.faces), mass(mesh.vertices, mesh.faces)
    area = np.maximum(area, SMALLEST_AREA * area.mean())
    B = L.T @ sp.diags(1 / area) @ L + sp.diags(area / reach_mm**4)
    inside = sp.csc_matrix(pick @ B @ pick.T)
    factor = splu(inside, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    pulls = np.asarray(D.todense()).T
    pulled = np.zeros(pulls.shape)
    pulled[free] = factor.solve(np.ascontiguousarray(pulls[free]))
    return pulled


def interpolate_from_points(
    mesh: Mesh,
    attachment: Attachment,
    reach_mm: float,
    stiffness: float = 0.0,
    where: Int[np.ndarray, " k"] | None = None,
) -> Float[np.ndarray, "n points"]:
    """The matrix S that carries values at attached points to every vertex, smoothly along the surface.

    Column i minimises |D u - e_i|^2 + stiffness * bending energy of u (see `green_functions`), so two lips do not see
    each other through the air. With stiffness 0 the values are met exactly.

    Args:
        stiffness: mm^2; how much misfit is taken for smoothness.
        where: as in `green_functions`.
    """
    D = attachment.matrix(mesh)
    pulled = green_functions(mesh, D, reach_mm, where)
    meets = D @ pulled + stiffness * np.eye(len(attachment.faces))
    return np.linalg.solve(meets.T, pulled.T).T
