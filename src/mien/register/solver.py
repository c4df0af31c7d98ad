"""Least squares over vertices: sums of point and plane terms, by preconditioned conjugate gradients."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float
from scipy.sparse.linalg import splu

from .residuals import PlaneTerm, PointTerm

FACTOR_UP_TO = 8000
"""Vertices up to which a factor of the whole is worth its time."""


@dataclass(frozen=True)
class SolveResult:
    """Where `solve_vertices` arrived."""

    vertices: Float[np.ndarray, "n 3"]
    converged: bool
    """False where the iterations ran out first."""
    iterations: int


def solve_vertices(
    points: Sequence[PointTerm],
    planes: PlaneTerm | None,
    start: Float[np.ndarray, "n 3"],
    damping: float = 1e-6,
    factor_up_to: int = FACTOR_UP_TO,
    iterations: int = 60,
    tolerance: float = 1e-3,
    prolongation: sp.csr_matrix | None = None,
) -> SolveResult:
    """Minimise the sum of the terms from `start` (n, 3).

    The point terms' matrix is one for x, y and z. Up to `factor_up_to` vertices its factor is the preconditioner; on
    more, the diagonal is, and with `prolongation` the factor on a coarser mesh beside it, without which what is long
    and soft would hardly move in so few iterations. Planes couple x, y and z; the iteration takes them exactly.

    Args:
        damping: pull towards `start`, as a share of the mean diagonal: holds what no term holds.
        tolerance: stop when the residual of the normal equations has fallen to this share.
        prolongation: (n, k), the vertices' displacements from those of a coarser mesh.
    """
    n = len(start)
    A = sp.csr_matrix((n, n))
    rhs = np.zeros((n, 3))
    for term in points:
        A = A + term.matrix.T @ term.matrix
        rhs += term.matrix.T @ term.target
    hold = damping * float(A.diagonal().mean())
    A = sp.csr_matrix(A + hold * sp.identity(n))
    rhs += hold * start
    normals = np.zeros((n, 3)) if planes is None else planes.normals
    if planes is not None:
        rhs += planes.offsets[:, None] * normals

    def apply(x: np.ndarray) -> np.ndarray:
        return A @ x + normals * np.einsum("nd,nd->n", normals, x)[:, None]

    precondition = _factor(A, normals) if n <= factor_up_to else _two_levels(A, normals, prolongation)
    return conjugate_gradients(apply, rhs, start, precondition, iterations, tolerance)


def _factor(A: sp.csr_matrix, normals: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Solve with A and the planes' weights as if they held in every direction."""
    weights = np.einsum("nd,nd->n", normals, normals)
    lu = splu(sp.csc_matrix(A + sp.diags(weights)), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return lambda r: np.ascontiguousarray(lu.solve(r))


def _two_levels(
    A: sp.csr_matrix, normals: np.ndarray, prolongation: sp.csr_matrix | None
) -> Callable[[np.ndarray], np.ndarray]:
    """The diagonal on the fine mesh and the factor on the coarse one, added up."""
    fine = _diagonal(A, normals)
    if prolongation is None:
        return fine
    P = prolongation
    Pt = sp.csr_matrix(P.T)
    held = A + sp.diags(np.einsum("nd,nd->n", normals, normals))
    coarse = _factor(sp.csr_matrix(Pt @ (held @ P)), np.zeros((Pt.get_shape()[0], 3)))
    return lambda r: fine(r) + P @ coarse(Pt @ r)


def _diagonal(A: sp.csr_matrix, normals: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Solve with the 3 x 3 blocks a I + n n^T on the diagonal (Sherman and Morrison)."""
    a = A.diagonal()[:, None]
    share = normals / (a + np.einsum("nd,nd->n", normals, normals)[:, None])
    return lambda r: (r - share * np.einsum("nd,nd->n", normals, r)[:, None]) / a


def conjugate_gradients(
    apply: Callable[[np.ndarray], np.ndarray],
    rhs: Float[np.ndarray, "n 3"],
    start: Float[np.ndarray, "n 3"],
    precondition: Callable[[np.ndarray], np.ndarray],
    iterations: int,
    tolerance: float,
) -> SolveResult:
    """Solve apply(x) = rhs, apply symmetric and positive, from `start`, until the residual falls by `tolerance`."""
    x = start.copy()
    r = rhs - apply(x)
    z = precondition(r)
    p, rz = z, _dot(r, z)
    first, done = rz, 0
    while done < iterations and rz > tolerance**2 * first and rz > 0:
        done += 1
        q = apply(p)
        step = rz / _dot(p, q)
        x += step * p
        r -= step * q
        z = precondition(r)
        rz, before = _dot(r, z), rz
        p = z + rz / before * p
    return SolveResult(x, rz <= tolerance**2 * first, done)


def _dot(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.einsum("nd,nd->", a, b))
