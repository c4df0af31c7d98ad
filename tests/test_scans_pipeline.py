"""A take and scans of its frames, staged small: one topology, a rig, a performance; bad scans are left out."""

import json

import numpy as np
import pytest

from command import mien
from face_model import needs_model
from mien.errors import BadInput
from mien.faces import load_face
from mien.io.gltf import read_performance
from mien.io.markers import write_c3d
from mien.io.meshes import write_mesh
from mien.mesh import Mesh, Scan, mass
from mien.reports.scans import scans_record, surface_distances
from mien.scans.fitted_scan import FittedScan
from mien.scans.pipeline import ScansConfig, lay_markers, register_scans
from mien.scans.reconstruct import solve_on_scans
from mien.scans.take_in_head import TakeInHead
from mien.stage.score_material import score_material
from mien.step_cache import StepCache
from mien.takes.preprocess import preprocess_take
from scan_stage import FRAMES, QUICK, scan_stage


def nothing() -> Scan:
    return Scan(Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), name="empty")


def flat() -> Mesh:
    """A wall."""
    x, y = np.meshgrid(np.linspace(-300, 300, 30), np.linspace(-300, 300, 30))
    i = np.arange(900).reshape(30, 30)
    a, b, c, d = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(900)])
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def test_scans_that_markers_do_not_fit_are_left_out_and_the_rest_goes_on(tmp_path):
    _, take, _, scans = scan_stage()
    expressions = preprocess_take(take.markers).positions[[*FRAMES, FRAMES[0]]]
    meshes = {s.scan.name: s.scan.mesh for s in scans} | {"wall": flat()}
    fitted = tuple(FittedScan(Scan(mesh, name=name), 0, mesh, None) for name, mesh in meshes.items())
    given = TakeInHead(take.markers.labels, fitted, expressions)
    cached = StepCache(tmp_path)
    left, frames, found = lay_markers(given, load_face(), ScansConfig(), cached)
    assert [scan.name for scan in left.scans] == [frame.name for frame in frames] == ["s_010", "s_070", "s_110"]
    assert [out.name for out in left.left_out] == ["wall"]
    assert "do not fit the scan" in left.left_out[0].why or "in two ways" in left.left_out[0].why
    assert len(found.scans) == 3
    with pytest.raises(BadInput, match="wall: the markers"):
        lay_markers(given, load_face(), ScansConfig(strict=True), cached)


@pytest.fixture(scope="module")
def registered(tmp_path_factory):
    """Three scans and an empty one as a rig, and where its finished steps are."""
    _, take, _, scans = scan_stage()
    work = tmp_path_factory.mktemp("scans") / "work"
    source, frames = [s.scan for s in scans] + [nothing()], [*FRAMES, 50]
    return register_scans(take.markers, source, frames, load_face(), QUICK, work=work), source, frames, work


@needs_model
def test_a_take_and_its_scans_become_a_rig_that_plays_the_take(registered):
    _, take, *_ = scan_stage()
    found, source, frames, work = registered
    assert [out.name for out in found.left_out] == ["empty"]
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
    kept = {file.name: file.stat().st_mtime_ns for file in work.iterdir()}
    again = register_scans(take.markers, source, frames, load_face(), QUICK, work=work)
    np.testing.assert_allclose(again.skin, found.skin, atol=1e-6)
    assert {file.name: file.stat().st_mtime_ns for file in work.iterdir()} == kept
    record = scans_record(found, distances, "take.c3d")
    assert json.loads(json.dumps(record))["scans"]["s_070"]["frame"] == 70


@needs_model
def test_the_command_leaves_a_rig_that_solve_takes_up(registered, tmp_path, monkeypatch, capsys):
    _, take, _, scans = scan_stage()
    given = {}

    def remembered(markers, scans, frames, *rest, **more):
        given.update(more, names=[scan.name for scan in scans], frames=frames)
        return registered[0]

    monkeypatch.setattr("mien.scans.pipeline.register_scans", remembered)
    (tmp_path / "scans").mkdir()
    for staged in scans:
        write_mesh(tmp_path / "scans" / f"{staged.scan.name}.ply", staged.scan.mesh)
    write_c3d(tmp_path / "take.c3d", take.markers)
    (tmp_path / "selection.json").write_text(json.dumps({"frames": [*FRAMES, 130]}))
    files = {"markers": tmp_path / "take.c3d", "selection": tmp_path / "selection.json"}
    mien("register", tmp_path / "scans", output=tmp_path / "face.glb", **files)
    assert (given["names"], given["frames"]) == (["s_010", "s_070", "s_110"], list(FRAMES))
    assert given["work"] == tmp_path / "face.work"
    record = json.loads((tmp_path / "face.register.json").read_text())
    assert set(record["scans"]) == {"s_010", "s_070", "s_110"}
    assert (tmp_path / "face.html").stat().st_size > 10_000
    mien("solve", tmp_path / "take.c3d", rig=tmp_path / "face.glb", output=tmp_path / "perf.glb")
    performance = read_performance(tmp_path / "perf.glb")
    jaw = performance.weights[:, performance.rig.index("s_070")]
    assert jaw[70] > 0.8 > 0.2 > jaw[10]
    told = capsys.readouterr().out
    assert "left out: selected frame 130: it has no scan" in told
    assert "3 scans" in told
