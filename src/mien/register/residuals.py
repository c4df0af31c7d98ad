"""The terms of nonrigid registration (Huang 2011, eq. 7): one short function a term, each a weighted residual.

The unknown x is the template's vertices (n, 3). The solver knows nothing of faces: it adds up terms of two kinds.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int


@dataclass(frozen=True)
class PointTerm:
    """|matrix @ x - target|^2, alike in x, y and z."""

    matrix: sp.csr_matrix
    """(r, n)."""
    target: Float[np.ndarray, "r 3"]

    def residual(self, x: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "r 3"]:
        """matrix @ x - target."""
        return self.matrix @ x - self.target

    def cost(self, x: Float[np.ndarray, "n 3"]) -> float:
        """The sum of squares."""
        return float((self.residual(x) ** 2).sum())


@dataclass(frozen=True)
class PlaneTerm:
    """sum_i (normals_i . x_i - offsets_i)^2: vertices held to planes. The normals carry the square root of a weight."""

    normals: Float[np.ndarray, "n 3"]
    offsets: Float[np.ndarray, " n"]

    def residual(self, x: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
        """Weighted signed distances to the planes."""
        return np.einsum("nd,nd->n", self.normals, x) - self.offsets

    def cost(self, x: Float[np.ndarray, "n 3"]) -> float:
        """The sum of squares."""
        return float((self.residual(x) ** 2).sum())


@dataclass(frozen=True)
class Stencil:
    """The edges of a mesh with their cotangent weights: what the shape terms are made of."""

    edges: Int[np.ndarray, "e 2"]
    weights: Float[np.ndarray, " e"]
    """Never negative: obtuse corners count for nothing rather than against."""
    incidence: sp.csr_matrix
    """(e, n): row k is sqrt(weight) (x_i - x_j), so that incidence^T incidence is the Laplacian L."""
    mass: Float[np.ndarray, " n"]
    """Area of each vertex, mm^2."""


def marker_term(matrix: sp.csr_matrix, points: Float[np.ndarray, "k 3"], weights: Float[np.ndarray, " k"]) -> PointTerm:
    """sum_c w_c |D_c x - points_c|^2: markers or landmarks meet their places (first term of eq. 7). Points in mm."""
    root = np.sqrt(weights)
    return PointTerm(sp.csr_matrix(sp.diags(root) @ matrix), root[:, None] * points)


def laplacian_term(
    stencil: Stencil, rotated_edges: Float[np.ndarray, "e 3"], weight: float, length: float
) -> PointTerm:
    """w l^2 |M^(-1/2) (L x - b)|^2: the surface bends no more than the template (second term of eq. 7).

    b = incidence^T rotated_edges are the template's differential coordinates, L v_s, each turned with its
    neighbourhood (`rotated_edges`), without which a turned template would be punished for turning. The masses make
    the sum an integral over the surface, so that the weight means the same on any mesh; `length` (mm) is the spacing
    of vertices at which it means what it does in the paper.
    """
    root = np.sqrt(weight) * length / np.sqrt(stencil.mass)
    matrix = sp.diags(root) @ (stencil.incidence.T @ stencil.incidence)
    return PointTerm(sp.csr_matrix(matrix), root[:, None] * (stencil.incidence.T @ rotated_edges))


def membrane_term(stencil: Stencil, rotated_edges: Float[np.ndarray, "e 3"], weight: float) -> PointTerm:
    """w sum_ij w_ij |(x_i - x_j) - R (s_i - s_j)|^2: the surface stretches little (Sorkine and Alexa 2007, eq. 3)."""
    root = np.sqrt(weight)
    return PointTerm(root * stencil.incidence, root * rotated_edges)


def point_term(points: Float[np.ndarray, "n 3"], weights: Float[np.ndarray, " n"]) -> PointTerm:
    """sum_i w_i |x_i - points_i|^2: vertices meet points, such as their closest ones (third term of eq. 7)."""
    root = np.sqrt(weights)
    return PointTerm(sp.csr_matrix(sp.diags(root)), root[:, None] * points)


def plane_term(
    points: Float[np.ndarray, "n 3"], normals: Float[np.ndarray, "n 3"], weights: Float[np.ndarray, " n"]
) -> PlaneTerm:
    """sum_i w_i (normals_i . (x_i - points_i))^2: the same, but a vertex may slide along the surface."""
    weighted = np.sqrt(weights)[:, None] * normals
    return PlaneTerm(weighted, np.einsum("nd,nd->n", weighted, points))
