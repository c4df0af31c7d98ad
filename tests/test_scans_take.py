"""A take and scans of its frames, staged small: markers on scans, one topology, a rig, a performance."""

import json

import numpy as np
import pytest

from face_model import needs_model
from mien.cli.register import register
from mien.cli.solve import solve
from mien.errors import BadInput
from mien.faces import load_face
from mien.fitting.register_scan import RegisterConfig
from mien.io.gltf import read_performance, read_rig
from mien.io.markers import write_c3d
from mien.io.meshes import write_mesh
from mien.mesh import Mesh, mass
from mien.register import Surface
from mien.reports.scans import scans_record, surface_distances
from mien.scans.fine_scale import FineConfig
from mien.scans.marker_registration import find_start, packed, register_markers, unpacked
from mien.scans.pipeline import ScansConfig, register_scans, resting_first
from mien.scans.reconstruct import solve_on_scans
from mien.scans.template import EIGHT, make_template
from mien.stage import MocapConfig, ScanConfig, make_performer, marker_layout, perform, scan
from mien.stage.score_material import material_under, scan_errors, score_material
from mien.step_cache import Store
from mien.takes.preprocess import prepare

FRAMES = (10, 70, 110)




@pytest.fixture(scope="module")
def stage():
    """A take of rest, open jaw, smile, and coarse scans of the three."""
    actor = make_performer(5)
    weights = np.zeros((140, len(actor.names)))
    swell = np.sin(np.linspace(0, np.pi, 40)) ** 0.5
    weights[50:90, actor.names.index("jawOpen")] = 0.6 * swell
    for side in ("Left", "Right"):
        weights[90:130, actor.names.index(f"mouthSmile{side}")] = 0.8 * swell
    layout = marker_layout(actor, 60)
    take = perform(actor, weights, 60.0, layout, MocapConfig(jitter=0.05, dropouts=0.01), seed=5)
    config = ScanConfig(vertices=12_000, performed=0.2, colour=False)
    scans = [scan(actor, weights[f], config, seed=20 + i, name=f"s_{f:03d}") for i, f in enumerate(FRAMES)]
    return actor, take, layout, scans


@pytest.fixture(scope="module")
def on_scans(stage):
    _, take, _, scans = stage
    expressions = prepare(take.markers).positions[list(FRAMES)]
    return register_markers(expressions, [Surface(s.scan.mesh) for s in scans])


def test_markers_are_found_on_scans_in_frames_of_their_own(stage, on_scans):
    _, take, layout, scans = stage
    for staged, found in zip(scans, on_scans.scans, strict=True):
        true = staged.truth.points(layout.attachment)
        off = np.linalg.norm(found.attachment.points(staged.scan.mesh) - true, axis=1)[found.covered]
        assert found.covered.mean() > 0.85
        assert off.mean() < 1.0
    assert abs(np.mean(on_scans.standoff) - take.truth.standoff.mean()) < 0.4


def test_the_nonrigid_step_brings_markers_closer_than_the_rigid_one(on_scans):
    for found in on_scans.scans:
        assert np.sqrt((found.off[found.covered] ** 2).mean()) < found.rigid_rms + 1e-9
        np.testing.assert_allclose(found.mix.sum(), 1.0, atol=1e-9)


def test_markers_on_scans_survive_the_store(on_scans):
    back = unpacked(packed(on_scans))
    for one, other in zip(on_scans.scans, back.scans, strict=True):
        np.testing.assert_array_equal(one.T_head_scan.rotation, other.T_head_scan.rotation)
        np.testing.assert_array_equal(one.attachment.barycentric, other.attachment.barycentric)
        assert one.rigid_rms == other.rigid_rms


def test_a_scan_of_something_else_is_refused(stage):
    _, take, _, _ = stage
    markers = prepare(take.markers).positions[FRAMES[0]]
    x, y = np.meshgrid(np.linspace(-300, 300, 30), np.linspace(-300, 300, 30))
    i = np.arange(900).reshape(30, 30)
    quads = [i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]]
    a, b, c, d = (q.ravel() for q in quads)
    wall = Mesh(
        np.column_stack([x.ravel(), y.ravel(), np.zeros(900)]),
        np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]),
    )
    with pytest.raises(BadInput, match=r"wall: the markers (of its frame do not fit|fit the scan in two ways)"):
        find_start(markers, Surface(wall), "wall")


def test_the_calmest_scan_comes_first_and_frames_must_be_in_the_take(stage):
    _, take, _, scans = stage
    ready = prepare(take.markers)
    found, frames = resting_first(ready, [scans[i].scan for i in (2, 0, 1)], [FRAMES[i] for i in (2, 0, 1)])
    assert (found[0].name, frames) == ("s_010", [10, 110, 70])
    with pytest.raises(BadInput, match="frame 9999 is not in the take"):
        resting_first(ready, [scans[0].scan], [9999])


def test_a_template_knows_its_parts_at_every_density():
    face = load_face()
    template = make_template(face.rig.neutral, face)
    assert set(template.regions) == {"face", *EIGHT}
    assert set(template.parts) == set(face.parts) - {"skin"}
    skin = template.skin.mesh.vertices
    np.testing.assert_allclose(template.whole(skin)[template.members], skin, atol=0.2)
    up = np.array([0.0, 3.0, 0.0])
    shifted = template.whole(skin + up)
    np.testing.assert_allclose(shifted, face.rig.neutral.vertices + up, atol=0.3)
    held = template.attach(skin, skin[template.shown][::50] + 0.1)
    assert template.shown[template.skin.mesh.faces[held.faces]].all()
    lids = np.concatenate(list(face.contours.values()))
    assert template.off_edges[np.isin(template.members, lids)].max() < 0.01


def test_the_truth_scores_nothing_and_a_frozen_face_scores_one(stage):
    actor, take, _, scans = stage
    truth, some = take.truth, np.flatnonzero(actor.skin)[::9]
    frames, areas = np.arange(0, 140, 7), mass(actor.neutral.vertices, actor.neutral.faces)[some]
    moving = score_material(
        lambda f: actor.vertices(truth.weights[[f]])[0][some], truth.T_lab_face, truth, 0, frames, areas
    )
    assert moving.error.max() < 1e-6
    mean = actor.vertices(truth.weights[frames]).mean(axis=0)[some]
    still = actor.vertices(truth.weights[[0]])[0][some]
    frozen = score_material(lambda f: mean if f else still, truth.T_lab_face, truth, 0, frames, areas)
    assert 0.9 < frozen.ratio < 1.0 + 1e-6
    true = [s.truth.T_scan_face.inverse().apply(s.truth.vertices) for s in scans]
    T = [s.truth.T_scan_face.inverse() for s in scans]
    assert scan_errors([x[some] for x in true], T, scans).max() < 1e-6
    assert material_under(actor, true[0], true[0][some])[1].max() < 1e-9


@needs_model
def test_a_take_and_its_scans_become_a_rig_that_plays_the_take(stage, tmp_path):
    _, take, _, scans = stage
    config = ScansConfig(
        density=0, reference=RegisterConfig(), fine=FineConfig(sweeps=1, pixel_mm=1.5, curvature_radius_mm=6.0)
    )
    store = Store(tmp_path / "work")
    source, frames = [s.scan for s in scans], list(FRAMES)
    found = register_scans(take.markers, source, frames, load_face(), config, store=store)
    assert (found.scan_rig.resting, found.scan_rig.rig.names) == ("s_010", ("s_070", "s_110"))
    distances = surface_distances(found)
    assert np.nanmean(distances) < 0.15
    solved = solve_on_scans(take.markers, found.scan_rig)
    template = found.template
    some = template.members[np.flatnonzero((template.regions["face"] > 0.5) & template.shown)]
    rig, weights = solved.performance.rig, solved.performance.weights
    score = score_material(
        lambda f: rig.vertices(weights[f])[some], solved.T_lab_face, take.truth, 10, np.arange(0, 140, 5),
        mass(rig.neutral.vertices, rig.neutral.faces)[some],
    )  # fmt: skip
    assert score.ratio < 0.45
    assert score.ratio_strongest < 0.25
    kept = {file.name: file.stat().st_mtime_ns for file in store.folder.iterdir()}
    again = register_scans(take.markers, source, frames, load_face(), config, store=store)
    np.testing.assert_array_equal(again.skin, found.skin)
    assert {file.name: file.stat().st_mtime_ns for file in store.folder.iterdir()} == kept
    record = scans_record(found, distances, "take.c3d")
    assert json.loads(json.dumps(record))["scans"]["s_070"]["frame"] == 70


def test_the_command_tells_what_is_wrong(stage, tmp_path):
    _, take, _, scans = stage
    folder = tmp_path / "scans"
    folder.mkdir()
    for staged in scans[:2]:
        write_mesh(folder / f"{staged.scan.name}.ply", staged.scan.mesh)
    write_c3d(tmp_path / "take.c3d", take.markers)
    (tmp_path / "selection.json").write_text(json.dumps({"frames": list(FRAMES)}))
    files = {"markers": "take.c3d", "selection": "selection.json", "output": "face.glb"}
    given = {name: tmp_path / file for name, file in files.items()}
    with pytest.raises(BadInput, match="1 of 3 selected frames have no scan: 110"):
        register(folder, **given)
    with pytest.raises(BadInput, match="a folder; its scans need the take"):
        register(folder, output=tmp_path / "face.glb")
    with pytest.raises(BadInput, match="one scan; --markers"):
        register(folder / "s_010.ply", **given)
    (folder / "s_070.ply").rename(folder / "s_071.ply")
    with pytest.raises(BadInput, match="frame 71 is not among the selected"):
        register(folder, **given)
    assert not (tmp_path / "face.glb").exists()


@needs_model
def test_the_command_leaves_a_rig_that_solve_takes_up(stage, tmp_path, monkeypatch, capsys):
    _, take, _, scans = stage
    folder = tmp_path / "scans"
    folder.mkdir()
    for staged in scans[:2]:
        write_mesh(folder / f"{staged.scan.name}.ply", staged.scan.mesh)
    write_c3d(tmp_path / "take.c3d", take.markers)
    (tmp_path / "selection.json").write_text(json.dumps({"frames": list(FRAMES)}))
    quick = ScansConfig(fine=FineConfig(sweeps=0, pixel_mm=1.5, curvature_radius_mm=6.0))
    monkeypatch.setattr("mien.scans.pipeline.ScansConfig", lambda: quick)
    register(
        folder, output=tmp_path / "face.glb", markers=tmp_path / "take.c3d", selection=tmp_path / "selection.json",
        density=0, partial=True,
    )  # fmt: skip
    rig = read_rig(tmp_path / "face.glb")
    assert rig.names == ("s_070",)
    record = json.loads((tmp_path / "face.register.json").read_text())
    assert set(record["scans"]) == {"s_010", "s_070"}
    assert (tmp_path / "face.html").stat().st_size > 10_000
    solve(tmp_path / "take.c3d", rig=tmp_path / "face.glb", output=tmp_path / "perf.glb")
    performance = read_performance(tmp_path / "perf.glb")
    jaw = performance.weights[:, 0]
    assert jaw[70] > 0.8 > 0.2 > jaw[10]
    assert "2 scans" in capsys.readouterr().out
