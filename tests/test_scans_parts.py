"""The parts of registering scans to a take, by hand and by laws."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.faces import load_face
from mien.io.gltf import read_rig, write_rig
from mien.mesh import Attachment, Mesh, Scan, closest_point, submesh, vertex_normals
from mien.mesh.cluster import clustered
from mien.mesh.scan_color import vertex_colours
from mien.register import Surface
from mien.rig import Rig
from mien.scans.pipeline import calmed
from mien.scans.reconstruct import ReconstructConfig, correctives, meet_markers, smoothed, solve_on_scans, solve_weights
from mien.scans.scan_files import match_scans
from mien.scans.scan_rig import ScanRig, marker_record, read_scan_rig, write_record
from mien.scans.template import laid_over, make_template, own_template, sound
from mien.step_cache import Store, fingerprint
from mien.transforms import Transform, rotation_from_vector


def sheet(n: int = 15, size: float = 60.0) -> Mesh:
    """A gently domed square, face space."""
    x, y = np.meshgrid(np.linspace(-size, size, n), np.linspace(-size, size, n))
    vertices = np.column_stack([x.ravel(), y.ravel(), 80 - (x.ravel() ** 2 + y.ravel() ** 2) / 150])
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def markers_on(mesh: Mesh, count: int = 25, seed: int = 0) -> Attachment:
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.linspace(-45, 45, 5), np.linspace(-45, 45, 5)), -1).reshape(-1, 2)[:count]
    points = np.column_stack([grid + rng.uniform(-3, 3, grid.shape), np.full(len(grid), 60.0)])
    return closest_point(mesh, points).attachment()


def small_rig(seed: int = 0) -> ScanRig:
    """A sheet with three smooth targets and its markers, none of them standing off."""
    mesh, rng = sheet(), np.random.default_rng(seed)
    waves = rng.normal(size=(3, 2)) / 40
    deltas = np.stack([np.sin(mesh.vertices[:, :2] @ w)[:, None] * rng.normal(size=3) * 4 for w in waves])
    rig, place = Rig(mesh, deltas, ("smile", "frown", "pucker")), markers_on(mesh)
    shapes = np.concatenate([mesh.vertices[None], mesh.vertices + deltas])
    expressions = np.stack([place.points(mesh.with_vertices(x)) for x in shapes])
    labels = tuple(f"M{i:02d}" for i in range(len(place.faces)))
    return ScanRig(rig, "rest", labels, place, np.zeros(len(labels)), expressions, np.ones(len(labels), bool))


def test_clustering_keeps_the_shape_and_thins_it():
    mesh = sheet(41)
    thin = clustered(mesh, 10.0)
    assert len(thin.vertices) < len(mesh.vertices) / 5
    assert closest_point(mesh, thin.vertices).distances.max() < 0.5
    assert (thin.faces[:, 0] != thin.faces[:, 1]).all()


def test_a_quiet_parabola_passes_unchanged_and_noise_falls():
    t = np.arange(60) / 60.0
    path = np.stack([3 * t, 5 * t**2, 1 - t], 1)[:, None].repeat(4, axis=1) + np.arange(4)[:, None]
    frames = [0, 30, 41]
    np.testing.assert_allclose(calmed(path, frames, 60.0)[1:], path[frames[1:]], atol=1e-9)
    noisy = path + np.random.default_rng(0).normal(size=path.shape) * 0.1
    left = np.abs(calmed(noisy, frames, 60.0)[1:] - path[frames[1:]]).mean()
    assert left < 0.8 * np.abs(noisy - path).mean()


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


def play(found: ScanRig, weights: np.ndarray, seed: int = 3, extra: np.ndarray | None = None):
    """A take on the rig with a moving head; `extra` (frames, markers, 3) is added in face space."""
    rng = np.random.default_rng(seed)
    moved = found.expressions[0] + np.tensordot(weights, found.expressions[1:] - found.expressions[0], axes=1)
    moved = moved if extra is None else moved + extra
    turn = np.cumsum(rng.normal(size=(len(weights), 3)) * 0.004, axis=0)
    T = Transform(rotation_from_vector(turn), np.cumsum(rng.normal(size=(len(weights), 3)) * 0.3, axis=0))
    return Markers(T.apply(moved), found.labels, 60.0), T


def gestures(frames: int = 240, seed: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, frames)[:, None]
    weights = np.maximum(np.sin(2 * np.pi * (t * rng.uniform(2, 4, 3) + rng.random(3))) - 0.3, 0) * 0.8
    weights[:90] = 0
    return weights


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


def test_takes_with_other_markers_are_refused():
    found = small_rig()
    take, _ = play(found, gestures())
    with pytest.raises(BadInput, match=r"0 of the rig's 25 markers"):
        solve_on_scans(replace(take, labels=tuple(f"X{i}" for i in range(25))), found)
    fewer = replace(take, positions=take.positions[:, :20], labels=take.labels[:20])
    assert solve_on_scans(fewer, found).residuals.shape[1] == 20


def test_the_record_of_a_rig_reads_back(tmp_path):
    found = small_rig()
    write_rig(tmp_path / "face.glb", found.rig)
    write_record(tmp_path / "face.register.json", {"markers": marker_record(found)})
    back = read_scan_rig(tmp_path / "face.register.json", read_rig(tmp_path / "face.glb"))
    assert (back.labels, back.resting, back.rig.names) == (found.labels, "rest", found.rig.names)
    np.testing.assert_allclose(back.expressions, found.expressions, atol=1e-4)
    there, here = back.attachment.points(back.rig.neutral), found.attachment.points(found.rig.neutral)
    np.testing.assert_allclose(there, here, atol=1e-3)
    (tmp_path / "bad.json").write_text(json.dumps({"markers": {"labels": []}}))
    with pytest.raises(BadInput, match="does not belong"):
        read_scan_rig(tmp_path / "bad.json", found.rig)


def touch(folder, *names):
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).touch()
    return folder


def test_scans_find_their_frames(tmp_path):
    folder = touch(tmp_path / "scans", "frame_000123.ply", "take2_7.obj", "notes.txt")
    assert [(f.name, f.frame) for f in match_scans(folder, (7, 123))] == [("take2_7", 7), ("frame_000123", 123)]
    (folder / "scans.json").write_text('{"take2_7.obj": 5, "frame_000123.ply": 9}')
    assert [f.frame for f in match_scans(folder, (9, 5))] == [9, 5]


@pytest.mark.parametrize(
    ("names", "frames", "message"),
    [
        ((), (1, 2), "no scans in it"),
        (("smile.ply", "a_1.ply"), (1, 2), "ends in no frame number"),
        (("a_1.ply", "b_3.ply"), (1, 2), "frame 3 is not among the selected"),
        (("a_1.ply", "b_1.ply"), (1, 2), "frame 1 has a scan already"),
        (("a_1.ply", "b_2.ply"), (1, 2, 30, 40), "2 of 4 selected frames have no scan: 30, 40"),
    ],
)
def test_scans_that_match_no_frame_are_told(tmp_path, names, frames, message):
    with pytest.raises(BadInput, match=message):
        match_scans(touch(tmp_path / "scans", *names), frames)


def test_partial_goes_on_and_needs_two(tmp_path):
    folder = touch(tmp_path / "scans", "a_1.ply", "b_2.ply")
    assert len(match_scans(folder, (1, 2, 30), partial=True)) == 2
    with pytest.raises(BadInput, match="2 are needed"):
        match_scans(touch(tmp_path / "one", "a_1.ply"), (1, 2), partial=True)
    (folder / "scans.json").write_text('{"a_1.ply": "one"}')
    with pytest.raises(BadInput, match="a frame for each scan"):
        match_scans(folder, (1, 2))


def test_finished_work_is_read_not_made_again(tmp_path):
    calls = []

    def make():
        calls.append(1)
        return {"x": np.arange(6.0).reshape(2, 3).T}

    store = Store(tmp_path / "work")
    inputs = (np.ones(3), "a", ReconstructConfig())
    first, second = store.get("stage", inputs, make), store.get("stage", inputs, make)
    np.testing.assert_array_equal(first["x"], second["x"])
    assert len(calls) == 1
    store.get("stage", (np.ones(3), "a", ReconstructConfig(rounds=5)), make)
    assert len(calls) == 2
    kept = sorted((tmp_path / "work").iterdir())[0]
    kept.write_bytes(b"PK broken")
    store.get("stage", inputs, make)
    store.get("stage", (np.ones(3), "a", ReconstructConfig(rounds=5)), make)
    assert len(calls) == 3
    assert Store(None).get("stage", inputs, make)["x"].shape == (3, 2)


def test_fingerprints_differ_where_inputs_do():
    seen = {fingerprint(x) for x in (1, 1.5, "1", (1,), (1, 2), np.ones(2), np.ones((2, 1)), np.zeros(2), None, {})}
    assert len(seen) == 10
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})


def test_colours_come_from_the_texture_or_the_vertices():
    triangle = Mesh(np.eye(3), np.array([[0, 1, 2]]), uv=np.array([[0.1, 0.9], [0.9, 0.9], [0.1, 0.1]]))
    texture = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [9, 9, 9]]], np.uint8)
    np.testing.assert_allclose(vertex_colours(Scan(triangle, texture)), np.eye(3))
    plain = Mesh(np.eye(3), np.array([[0, 1, 2]]), colors=np.full((3, 3), 0.5))
    np.testing.assert_allclose(vertex_colours(Scan(plain)), 0.5)
    assert vertex_colours(Scan(Mesh(np.eye(3), np.array([[0, 1, 2]])))) is None


def test_a_sound_mesh_has_no_forks_and_is_in_one_piece():
    mesh = sheet(9)
    fin = np.array([[0, 1, 81]])
    far = np.array([[82, 83, 84]])
    touching = np.array([[40, 85, 86]])
    vertices = np.concatenate([mesh.vertices, mesh.vertices[[0, 70, 71, 72, 60, 61]] + np.array([0, 0, 9.0])])
    found = sound(Mesh(vertices, np.concatenate([mesh.faces, fin, far, touching])))
    assert 0 < len(mesh.faces) - len(found.faces) < 10
    same = sound(mesh)
    np.testing.assert_array_equal(same.vertices, mesh.vertices)
    assert len(same.faces) == len(mesh.faces)


def test_any_mesh_can_be_the_template():
    face = load_face()
    bundled = make_template(face.rig.neutral, face)
    skin = bundled.skin.mesh
    piece, _ = submesh(skin, np.flatnonzero((skin.vertices[skin.faces][..., 2] > 40).all(axis=1)))
    own = own_template(sound(piece), bundled)
    assert own.parts == {}
    assert 0.9 < own.regions["face"].max() <= 1.0
    np.testing.assert_allclose(own.whole(own.skin.mesh.vertices), own.mesh.vertices, atol=0.2)
    out = np.array([0.0, 0.0, 5.0])
    moved = skin.vertices + out
    target = Surface(Mesh(moved, skin.faces))
    laid = laid_over(sound(piece), skin, skin.with_vertices(moved), target)
    np.testing.assert_allclose(laid.vertices, sound(piece).vertices + out, atol=0.05)
