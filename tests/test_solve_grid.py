import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from mien.errors import BadInput
from mien.solve.grid import GridSolution, solve_grid

H, W = 34, 27


def problem(kept: float):
    """Edges of which a share is kept, weights that differ a thousandfold, and a part of the grid with neither."""
    rng = np.random.default_rng(0)
    weight = 10 ** rng.uniform(-3, 0, size=(H, W)) * (rng.random((H, W)) > 0.3)
    target, slopes = rng.normal(size=(H, W)), (rng.normal(size=(H, W - 1)), rng.normal(size=(H - 1, W)))
    edges = tuple(10 ** rng.uniform(-1, 2, size=s.shape) * (rng.random(s.shape) < kept) for s in slopes)
    weight[20:, 15:] = 0.0
    edges[0][20:, 14:] = 0.0
    edges[1][19:, 15:] = 0.0
    return target, weight, slopes, edges


def direct(target, weight, slopes, edges):
    number = np.arange(H * W).reshape(H, W)
    rows = []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        a, b = number[one].ravel(), number[other].ravel()
        place = (np.r_[: a.size, : a.size], np.r_[a, b])
        rows.append(sp.csr_matrix((np.r_[-np.ones(a.size), np.ones(a.size)], place), shape=(a.size, H * W)))
    D = sp.vstack(rows).tocsr()
    S, s = sp.diags(np.r_[edges[0].ravel(), edges[1].ravel()]), np.r_[slopes[0].ravel(), slopes[1].ravel()]
    A = D.T @ S @ D + sp.diags(weight.ravel())
    told = np.flatnonzero(A.diagonal() > 0)
    out = np.zeros(H * W)
    out[told] = spl.spsolve(A[told][:, told].tocsc(), (weight.ravel() * target.ravel() + D.T @ (S @ s))[told])
    return out.reshape(H, W)


def test_the_grid_solver_agrees_with_a_direct_one_and_leaves_what_is_not_asked_for_at_zero():
    found = solve_grid(*problem(1.0), tolerance=1e-10)
    assert found.converged
    assert found.iterations <= 70
    np.testing.assert_allclose(found.values, direct(*problem(1.0)), atol=1e-5)
    assert not found.values[21:, 16:].any()


def test_even_weights_need_few_iterations_at_any_size():
    def taken(size: int) -> GridSolution:
        rng = np.random.default_rng(1)
        even = (np.full((size, size - 1), 2.0), np.full((size - 1, size), 2.0))
        slopes = tuple(rng.normal(size=e.shape) for e in even)
        return solve_grid(rng.normal(size=(size, size)), np.full((size, size), 1e-3), slopes, even)

    assert all(taken(size).converged and taken(size).iterations <= 16 for size in (20, 200))


def test_nothing_to_go_by_is_told():
    zero = (np.zeros((3, 3)), np.zeros((2, 4)))
    with pytest.raises(BadInput, match="no pixel"):
        solve_grid(np.zeros((3, 4)), np.zeros((3, 4)), zero, zero)
