import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl

import light_scene
from mien.errors import BadInput
from mien.light.integrate import integrate, log_slopes, on_edges, solve_grid
from mien.light.triangulate import pixel_rays

LEFT = light_scene.rig().cameras[0]


def test_the_grid_solver_agrees_with_a_direct_one():
    rng = np.random.default_rng(0)
    h, w = 14, 11
    weight = rng.uniform(0.1, 1, size=(h, w)) * (rng.random((h, w)) > 0.3)
    target, slopes = rng.normal(size=(h, w)), (rng.normal(size=(h, w - 1)), rng.normal(size=(h - 1, w)))
    edges = (rng.uniform(0.2, 3, size=(h, w - 1)), rng.uniform(0.2, 3, size=(h - 1, w)))
    number = np.arange(h * w).reshape(h, w)
    empty = weight == 0
    usual = np.median(np.concatenate([e.ravel() for e in edges]))
    rows, filled = [], []
    for one, other, edge in ((np.s_[:, :-1], np.s_[:, 1:], edges[0]), (np.s_[:-1], np.s_[1:], edges[1])):
        a, b = number[one].ravel(), number[other].ravel()
        place = (np.r_[: a.size, : a.size], np.r_[a, b])
        rows.append(sp.csr_matrix((np.r_[-np.ones(a.size), np.ones(a.size)], place), shape=(a.size, h * w)))
        filled.append(np.where(empty[one] & empty[other], usual, edge))
    D = sp.vstack(rows).tocsr()
    S, s = sp.diags(np.r_[filled[0].ravel(), filled[1].ravel()]), np.r_[slopes[0].ravel(), slopes[1].ravel()]
    A = D.T @ S @ D + sp.diags(weight.ravel())
    direct = spl.spsolve(A.tocsc(), weight.ravel() * target.ravel() + D.T @ (S @ s)).reshape(h, w)
    found = solve_grid(target, weight, slopes, edges, tolerance=1e-10)
    assert found.converged
    np.testing.assert_allclose(found.values, direct, atol=1e-5)


def test_even_weights_need_one_iteration():
    rng = np.random.default_rng(1)
    even = (np.full((20, 29), 2.0), np.full((19, 30), 2.0))
    slopes = (rng.normal(size=(20, 29)), rng.normal(size=(19, 30)))
    assert solve_grid(rng.normal(size=(20, 30)), np.ones((20, 30)), slopes, even).iterations <= 2


def test_a_balls_normals_give_the_ball_back():
    truth, normals = light_scene.ball_depth(LEFT)
    rays = pixel_rays(LEFT.camera)
    with np.errstate(invalid="ignore"):
        mask = np.abs((normals * rays).sum(-1)) / np.linalg.norm(rays, axis=-1) > 0.3
    found = integrate(normals, LEFT.camera, rays, mask, float(np.nanmean(truth[mask])))
    off = (found - truth)[mask]
    assert np.abs(off - off.mean()).mean() < 0.3


def test_slopes_are_those_of_the_logarithm_of_depth():
    truth, normals = light_scene.ball_depth(LEFT)
    slopes = log_slopes(normals, LEFT.camera, pixel_rays(LEFT.camera))
    (across, down), _ = on_edges(slopes, np.ones(truth.shape))
    middle = np.s_[80:120, 60:100]
    np.testing.assert_allclose(across[middle], np.diff(np.log(truth), axis=1)[middle], atol=2e-5)
    np.testing.assert_allclose(down[middle], np.diff(np.log(truth), axis=0)[middle], atol=2e-5)


def test_nothing_to_go_by_is_told():
    zero = (np.zeros((3, 3)), np.zeros((2, 4)))
    with pytest.raises(BadInput, match="no pixel"):
        solve_grid(np.zeros((3, 4)), np.zeros((3, 4)), zero, zero)
    with pytest.raises(BadInput, match="no normal"):
        integrate(np.full((4, 4, 3), np.nan), LEFT.camera, np.ones((4, 4, 3)), np.ones((4, 4), bool), 500.0)
