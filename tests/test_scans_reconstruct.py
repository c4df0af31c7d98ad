"""From registered scans and a take to a performance: laws, known weights, correctives."""

from dataclasses import replace

import numpy as np
import pytest

from clamped_playback import played_with_clamping
from mien.errors import BadInput
from mien.io.gltf import write_performance
from mien.mesh import Mesh, vertex_normals
from mien.scans.reconstruct import ReconstructConfig, correctives, meet_markers, smoothed, solve_on_scans, solve_weights
from mien.transforms import Transform
from small_scans import gestures, play, small_rig


def test_scans_meet_their_markers_exactly_and_nothing_else_moves():
    found, rng = small_rig(), np.random.default_rng(1)
    mesh, place = found.rig.neutral, found.attachment
    standoff = np.full(len(found.labels), 2.0)
    shapes = np.stack([mesh.vertices, mesh.vertices + found.rig.deltas[0]])
    normals = [place.points(Mesh(vertex_normals(x, mesh.faces), mesh.faces)) for x in shapes]
    on = np.stack([place.points(Mesh(x, mesh.faces)) for x in shapes])
    up = np.stack([n / np.linalg.norm(n, axis=1, keepdims=True) for n in normals])
    there, covered = on + 2.0 * up, np.ones(on.shape[:2], bool)
    same = meet_markers(mesh, shapes, place, there, standoff, covered)
    np.testing.assert_allclose(same, shapes, atol=1e-9)
    pull = rng.normal(size=there.shape) * 0.5
    covered[1, 3] = False
    moved = meet_markers(mesh, shapes, place, there + pull, standoff, covered)
    at = np.stack([place.points(Mesh(x, mesh.faces)) for x in moved])
    np.testing.assert_allclose((at - on)[covered], pull[covered], atol=1e-6)
    assert np.abs(at - on - pull)[1, 3].max() > 0.05
    assert np.abs(moved - shapes).max() < 4 * np.abs(pull).max()


def test_known_weights_and_poses_come_back_and_gaps_do_not_matter():
    found, rng = small_rig(), np.random.default_rng(2)
    weights = np.maximum(rng.normal(size=(40, 3)) * 0.5, 0)
    take, T = play(found, weights)
    seen = rng.random((40, 25)) > 0.2
    positions = np.where(seen[..., None], take.positions, np.nan)
    config = ReconstructConfig(rounds=12)
    solved = solve_weights(found.expressions, positions, Transform.identity(40), config)
    np.testing.assert_allclose(solved.weights, weights, atol=1e-6)
    np.testing.assert_allclose(solved.T_lab_face.rotation, T.rotation, atol=1e-7)
    assert np.isnan(solved.missing[~seen]).all()
    against = found.expressions[0] - np.tensordot(weights, found.expressions[1:] - found.expressions[0], axes=1)
    assert (solve_weights(found.expressions, against, Transform.identity(40)).weights >= 0).all()


def test_a_take_on_its_own_rig_is_solved_to_its_weights():
    found, weights = small_rig(), gestures()
    take, T = play(found, weights)
    solved = solve_on_scans(take, found, ReconstructConfig(smooth_s=0.0))
    np.testing.assert_allclose(solved.performance.weights[:, :3], weights, atol=0.02)
    mine = solved.T_lab_face.apply(solved.performance.rig.vertices(solved.performance.weights))
    true = T.apply(found.rig.vertices(weights))
    assert np.linalg.norm(mine - true, axis=2).mean() < 0.05
    assert np.nanmean(solved.residuals) < 0.02


def test_smoothing_keeps_parabolas_and_gaps():
    t = np.linspace(0, 1, 50)
    path = np.stack([t, 3 * t**2, 1 - t], 1)[:, None].repeat(2, axis=1)
    np.testing.assert_allclose(smoothed(path, 6), path, atol=1e-12)
    path[20:22, 1] = np.nan
    np.testing.assert_array_equal(np.isnan(smoothed(path, 7)), np.isnan(path))
    np.testing.assert_array_equal(smoothed(path, 3), path)


def test_correctives_take_over_what_scans_cannot_mix():
    found, weights = small_rig(), gestures()
    swing = np.sin(np.linspace(0, 12, len(weights)))[:, None, None]
    bulge = np.exp(-((found.expressions[0][:, :2] / 25) ** 2).sum(axis=1))[None, :, None] * [0.0, 0.0, 2.0]
    take, _ = play(found, weights, extra=swing * bulge)
    plain = solve_on_scans(take, found, ReconstructConfig(correctives=0))
    more = solve_on_scans(take, found)
    assert np.nanmean(more.residuals) < 0.25 * np.nanmean(plain.residuals)
    assert plain.performance.rig.names == found.rig.names
    assert more.performance.rig.names[3] == "corrective_01"
    missing = np.zeros((10, len(found.labels), 3))
    assert correctives(found, np.arange(len(found.labels)), missing).names == ()


def test_the_file_of_a_take_on_scans_played_with_clamped_weights_shows_what_was_solved(tmp_path):
    """Scans beyond 1 and correctives of both signs: viewers clamp every weight to 0..1."""
    found, weights = small_rig(), gestures()
    weights[:, 0] *= 3.5
    swing = np.sin(np.linspace(0, 12, len(weights)))[:, None, None]
    bulge = np.exp(-((found.expressions[0][:, :2] / 25) ** 2).sum(axis=1))[None, :, None] * [0.0, 0.0, 2.0]
    take, _ = play(found, weights, extra=swing * bulge)
    performance = solve_on_scans(take, found).performance
    assert performance.weights.max() > 1.5
    assert performance.weights.min() < -0.5
    write_performance(tmp_path / "perf.glb", performance)
    frames = np.arange(0, len(weights), 24)
    solved = performance.rig.vertices(performance.weights[frames])
    np.testing.assert_allclose(played_with_clamping(tmp_path / "perf.glb")[frames], solved, atol=1e-3)


def test_takes_with_other_markers_are_refused():
    found = small_rig()
    take, _ = play(found, gestures())
    with pytest.raises(BadInput, match=r"0 of the rig's 25 markers"):
        solve_on_scans(replace(take, labels=tuple(f"X{i}" for i in range(25))), found)
    fewer = replace(take, positions=take.positions[:, :20], labels=take.labels[:20])
    assert solve_on_scans(fewer, found).residuals.shape[1] == 20


def test_smoothing_takes_noise_away():
    noise = np.random.default_rng(5).normal(size=(200, 4, 3))
    assert smoothed(noise, 6).std() < 0.75 * noise.std()
