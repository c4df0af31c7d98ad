"""Weights and pose of every frame."""

from dataclasses import replace

import numpy as np
import pytest

from marker_stage import FREE, acted, small_model
from mien.takes.frame_solve import SolveConfig, normal_equations, solve_frames, stillness, without_pose
from mien.takes.marker_model import MarkerModel
from mien.transforms import Transform, rotation_from_vector


def test_normal_equations_and_elimination_agree_with_plain_least_squares():
    model = small_model()
    rng = np.random.default_rng(12)
    used, r = rng.random((4, 40)) < 0.8, rng.normal(size=(4, 40, 3))
    M = np.diag([1.0, 1.0, 0.2])
    A = model.jacobian()
    G, b = normal_equations(A, M, r, used)
    reduced, right, back = without_pose(G, b)
    for t in range(4):
        rows = (np.sqrt(M) @ A[used[t]]).reshape(-1, A.shape[2])
        plain = np.linalg.lstsq(rows, (r[t, used[t]] @ np.sqrt(M)).ravel(), rcond=None)[0]
        w = np.linalg.solve(reduced[t], right[t])
        np.testing.assert_allclose(w, plain[:6], atol=1e-6)
        np.testing.assert_allclose(back[t, :, 0] - back[t, :, 1:] @ w, plain[6:], atol=1e-3)


def test_clean_markers_give_weights_and_pose_back():
    model = small_model()
    played = acted()
    W, T, X = played
    start = Transform(T.rotation @ rotation_from_vector(np.full((50, 3), 0.03)), T.translation + 2)
    solved = solve_frames(model, X, start, 60.0, config=FREE)
    np.testing.assert_allclose(solved.weights, W, atol=2e-3)
    np.testing.assert_allclose(solved.T_lab_face.rotation, T.rotation, atol=1e-3)
    assert np.nanmax(solved.residuals) < 0.05
    assert solved.converged


def test_the_lab_has_no_say():
    model = small_model()
    played = acted()
    _, T, X = played
    lab = Transform(rotation_from_vector(np.array([0.3, 2.0, -1.0])), np.array([100.0, 5, -70]))
    many = Transform(np.broadcast_to(lab.rotation, (50, 3, 3)), np.broadcast_to(lab.translation, (50, 3)))
    here = solve_frames(model, X, T, 60.0)
    there = solve_frames(model, lab.apply(X.reshape(-1, 3)).reshape(X.shape), many @ T, 60.0)
    np.testing.assert_allclose(here.weights, there.weights, atol=1e-5)


def test_gaps_outliers_and_empty_frames_do_no_harm():
    model = small_model()
    played = acted()
    W, T, X = played
    X = X.copy()
    X[5, :10], X[20] = np.nan, np.nan
    X[30, 3] += 60
    solved = solve_frames(model, X, T, 60.0, config=SolveConfig(sparsity=0.0, smoothness=0.0, ridge=1e-9, rounds=6))
    assert not solved.tracked[20]
    assert solved.tracked.sum() == 49
    np.testing.assert_array_equal(solved.weights[20], solved.weights[19])
    assert not solved.used[30, 3]
    np.testing.assert_allclose(solved.weights[[5, 30]], W[[5, 30]], atol=5e-3)


def test_smoothness_calms_and_sparsity_empties():
    model = small_model()
    played = acted()
    _, T, X = played
    noisy = X + np.random.default_rng(0).normal(size=X.shape)
    free = solve_frames(model, noisy, T, 60.0, config=FREE).weights
    smooth = solve_frames(model, noisy, T, 60.0, config=SolveConfig(sparsity=0.0, smoothness=1e4, ridge=0.0)).weights
    sparse = solve_frames(model, noisy, T, 60.0, config=SolveConfig(sparsity=200.0, smoothness=0.0, ridge=0.0)).weights
    assert np.abs(np.diff(smooth, axis=0)).mean() < 0.2 * np.abs(np.diff(free, axis=0)).mean()
    assert (sparse > 1e-6).sum() < (free > 1e-6).sum()


def test_poses_and_models_that_are_not_finite_are_refused():
    model, (_, T, X) = small_model(), acted()
    bad = Transform(T.rotation, np.where(np.arange(50)[:, None] == 3, np.nan, T.translation))
    with pytest.raises(ValueError, match="T_lab_face"):
        solve_frames(model, X, bad, 60.0)
    with pytest.raises(ValueError, match="model"):
        solve_frames(MarkerModel(model.neutral * np.nan, model.shapes), X, T, 60.0)


def test_still_markers_tell_the_pose_when_shapes_are_not_the_actors():
    rng = np.random.default_rng(3)
    reach = np.r_[np.full(10, 0.05), np.full(30, 1.0)][None, :, None]
    shapes = rng.normal(size=(6, 40, 3)) * 4 * reach
    model = MarkerModel(small_model().neutral, shapes)
    actor = MarkerModel(model.neutral, shapes + rng.normal(size=shapes.shape) * 2 * reach + [0.0, 1.5, 0] * reach)
    W, T, _ = acted()
    X = T.apply(actor.points(W))

    def wander(power: float) -> float:
        config = SolveConfig(sparsity=0.0, smoothness=0.0, still_power=power, outlier=np.inf)
        found = solve_frames(model, X, T, 60.0, config=config).T_lab_face
        at_rest = (T.inverse() @ found).apply(np.broadcast_to(model.neutral, X.shape))
        return float(np.linalg.norm(at_rest - model.neutral, axis=2).mean())

    assert wander(2.0) < 0.5 * wander(0.0)
    told = stillness(model, 2.0)
    assert told[:10].min() > 20 * told[10:].max()


def test_two_pairs_of_equations_leave_what_plain_least_squares_leaves():
    model, rng = small_model(), np.random.default_rng(5)
    used, r = np.ones((3, 40), bool), rng.normal(size=(3, 40, 3))
    worth = rng.uniform(0.1, 1, 40)
    A = model.jacobian()
    both = normal_equations(A, np.eye(3), r, used), normal_equations(A, np.eye(3), r, used, worth)
    reduced, right, back = without_pose(*both[0], *both[1])
    flat, root = A.reshape(120, -1), np.sqrt(np.repeat(worth, 3))
    J, S = flat[:, 6:], flat[:, :6]
    pose_of = np.linalg.lstsq(J * root[:, None], np.eye(120) * root[:, None], rcond=None)[0]
    keep = np.eye(120) - J @ pose_of
    for t in range(3):
        w = np.linalg.lstsq(keep @ S, keep @ r[t].ravel(), rcond=None)[0]
        np.testing.assert_allclose(np.linalg.solve(reduced[t], right[t]), w, atol=1e-6)
        np.testing.assert_allclose(back[t, :, 0] - back[t, :, 1:] @ w, pose_of @ (r[t].ravel() - S @ w), atol=1e-4)


@pytest.mark.parametrize("name", ["sparsity", "smoothness", "ridge"])
def test_every_price_holds_weights_back_at_its_default(name):
    model = small_model()
    _, T, X = acted()
    noisy = X + np.random.default_rng(0).normal(size=X.shape)
    held = solve_frames(model, noisy, T, 60.0).weights
    free = solve_frames(model, noisy, T, 60.0, config=replace(SolveConfig(), **{name: 0.0})).weights
    cost = {
        "sparsity": lambda w: w.sum(),
        "smoothness": lambda w: (np.diff(w, axis=0) ** 2).sum(),
        "ridge": lambda w: (w**2).sum(),
    }[name]
    assert cost(held) < 0.9999 * cost(free)
