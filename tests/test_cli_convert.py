"""`mien convert`: every route, run as a user runs it."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import light_dots
from command import mien
from gltf_files import foreign, performance
from marker_files import take, wide_csv
from mesh_files import bumpy
from mien.cli.kinds import LIGHT_SCAN, kind_of
from mien.errors import BadInput
from mien.io.gltf import read_performance, read_rig, write_performance
from mien.io.live_link_table import EYES, HEAD, SHAPES
from mien.io.livelink import read_live_link
from mien.io.markers import read_marker_file, read_markers
from mien.io.meshes import read_scan, write_mesh
from mien.light.disk.light_scan import write_light_scan
from test_io_rigs import folder_of


def test_marker_take_to_c3d(tmp_path, capsys):
    source = wide_csv(tmp_path / "a.csv", take().positions / 10)
    mien("convert", source, output=tmp_path / "a.c3d", units="cm", rate=50.0)
    back = read_marker_file(tmp_path / "a.c3d")
    np.testing.assert_allclose(back.markers.positions, take().positions, atol=1e-4)
    assert (back.markers.rate, back.up_source) == (50, "unknown")
    mien("convert", tmp_path / "a.csv", output=tmp_path / "b.c3d")
    told = capsys.readouterr()
    assert "read as cm" in told.err
    assert told.out.splitlines() == [f"wrote {tmp_path / 'a.c3d'}", f"wrote {tmp_path / 'b.c3d'}"]
    assert read_markers(tmp_path / "b.c3d").rate == 30


def test_performance_to_live_link_and_back(tmp_path):
    play = performance()
    write_performance(tmp_path / "a.glb", play)
    mien("convert", tmp_path / "a.glb", output=tmp_path / "a.csv")
    assert read_live_link(tmp_path / "a.csv").rate == 60
    mien("convert", tmp_path / "a.csv", output=tmp_path / "b.glb", rig=tmp_path / "a.glb")
    np.testing.assert_allclose(read_performance(tmp_path / "b.glb").weights, play.weights, atol=1e-6)
    mien("convert", tmp_path / "a.csv", output=tmp_path / "c.glb")
    bundled = read_performance(tmp_path / "c.glb")
    assert len(bundled.rig.names) == 52
    jaw = bundled.weights[:, bundled.rig.index("jawOpen")]
    np.testing.assert_allclose(jaw, play.weights[:, play.rig.index("jawOpen")], atol=1e-6)


def test_performance_to_a_mesh_a_frame(tmp_path):
    play = performance(3)
    write_performance(tmp_path / "a.glb", play)
    mien("convert", tmp_path / "a.glb", output=tmp_path / "frames", frames_as="obj", still_head=True)
    last = read_scan(tmp_path / "frames/frame_000002.obj").mesh
    np.testing.assert_allclose(last.vertices, play.rig.vertices(play.weights[2]), atol=1e-4)


def test_rigs_and_foreign_performances_to_glb(tmp_path):
    _, deltas, _ = folder_of(tmp_path / "shapes", ".ply")
    mien("convert", tmp_path / "shapes", output=tmp_path / "rig.glb")
    np.testing.assert_allclose(read_rig(tmp_path / "rig.glb").deltas[0], deltas["jawOpen"], atol=1e-4)
    mien("convert", tmp_path / "rig.glb", output=tmp_path / "again.glb")
    assert read_rig(tmp_path / "again.glb").names == ("jawOpen", "smile")
    mien("convert", foreign(tmp_path / "other.glb"), output=tmp_path / "ours.glb")
    assert read_performance(tmp_path / "ours.glb").weights.shape == (3, 2)


def test_scan_to_ply(tmp_path):
    mesh = bumpy(colors=True)
    write_mesh(tmp_path / "a.obj", mesh)
    mien("convert", tmp_path / "a.obj", output=tmp_path / "b.ply", units="cm")
    np.testing.assert_allclose(read_scan(tmp_path / "b.ply").mesh.vertices, mesh.vertices * 10, rtol=1e-5)


def test_a_scan_of_active_light_to_a_mesh(tmp_path):
    scan = light_dots.scan()
    write_light_scan(tmp_path / "a.exr", scan)
    mien("convert", tmp_path / "a.exr", output=tmp_path / "b.ply")
    np.testing.assert_allclose(read_scan(tmp_path / "b.ply").mesh.vertices, scan.mesh().vertices, rtol=1e-5)
    assert kind_of(tmp_path / "a.exr") is LIGHT_SCAN


def test_no_such_route(tmp_path):
    write_mesh(tmp_path / "a.obj", bumpy())
    with pytest.raises(BadInput, match=r"no way from \.obj to \.c3d; there is: a scan to \.obj or \.ply$"):
        mien("convert", tmp_path / "a.obj", output=tmp_path / "b.c3d")
    with pytest.raises(BadInput, match="no such file"):
        mien("convert", tmp_path / "gone.obj", output=tmp_path / "b.ply")
    assert not list(tmp_path.glob("b.*"))


def test_from_the_shell(tmp_path):
    """Bad input: one line on stderr, exit status 2, no output, the old file whole."""
    (tmp_path / "take.c3d").write_text("no C3D at all")
    (tmp_path / "out.c3d").write_text("old")
    command = [sys.executable, "-c", "from mien.cli.main import main; main()", "convert", "take.c3d", "-o", "out.c3d"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 2
    assert done.stderr == "mien: take.c3d: not a C3D file; give the .c3d that the capture program exported\n"
    assert done.stdout == ""
    assert Path(tmp_path / "out.c3d").read_text() == "old"


def test_a_converted_take_keeps_labels_rate_unit_and_gaps(tmp_path):
    """Centimetres with a gap and a label never seen, at 59.94 frames a second, come back as millimetres."""
    markers = take()
    positions = markers.positions / 10
    positions[:, 5] = np.nan
    extra = [("Time", [f"{t / 59.94:.6f}" for t in range(5)])]
    source = wide_csv(tmp_path / "take.csv", positions, lambda n, a: f"Jane:{n}_{a} [cm]", extra=extra)
    mien("convert", source, output=tmp_path / "take.c3d")
    back = read_marker_file(tmp_path / "take.c3d")
    assert (back.markers.labels, back.unit_mm, back.unit_source) == (markers.labels, 1.0, "file")
    np.testing.assert_allclose(back.markers.rate, 59.94, rtol=1e-4)
    np.testing.assert_allclose(back.markers.positions, positions * 10, atol=1e-4)
    mien("convert", source, output=tmp_path / "six.c3d", markers="M[0-4],M7")
    assert read_markers(tmp_path / "six.c3d").labels == ("M0", "M1", "M2", "M3", "M4", "M7")


def test_performance_to_alembic_usd_and_virtual_markers(tmp_path):
    play = performance(4)
    write_performance(tmp_path / "a.glb", play)
    mien("convert", tmp_path / "a.glb", output=tmp_path / "a.abc", still_head=True)
    assert (tmp_path / "a.abc").stat().st_size > 1000
    mien("convert", tmp_path / "a.glb", output=tmp_path / "a.usdz")
    mien("convert", tmp_path / "a.usdz", output=tmp_path / "b.glb")
    np.testing.assert_allclose(read_performance(tmp_path / "b.glb").weights, play.weights, atol=1e-6)
    mien("convert", tmp_path / "a.usdz", output=tmp_path / "a.c3d", count=20)
    assert read_markers(tmp_path / "a.c3d").labels[:2] == ("v001", "v002")
    with pytest.raises(BadInput, match=r"--count: expected 1\.\."):
        mien("convert", tmp_path / "a.glb", output=tmp_path / "a.c3d", count=0)


def test_virtual_markers_where_a_file_says(tmp_path):
    write_performance(tmp_path / "a.glb", performance(4))
    places = {f"m{i}": {"face": i, "barycentric": [1, 0, 0]} for i in range(8)}
    (tmp_path / "places.json").write_text(json.dumps({**places, "band": None}))
    mien("convert", tmp_path / "a.glb", output=tmp_path / "a.c3d", attachment=tmp_path / "places.json")
    markers = read_markers(tmp_path / "a.c3d")
    assert markers.labels == tuple(places)
    play = read_performance(tmp_path / "a.glb")
    last = play.T_world_face[3].apply(play.rig.vertices(play.weights[3]))
    np.testing.assert_allclose(markers.positions[3, 5], last[play.rig.neutral.faces[5, 0]], atol=1e-3)


def test_live_link_to_a_rig_and_back_is_the_same(tmp_path):
    """Weights and the head to 1e-4 of a table as the app writes it: yaw with a front of its own, a rate of 60."""
    rng = np.random.default_rng(5)
    table = rng.random((20, 61)) * np.r_[np.ones(52), np.full(9, 0.6)]
    table[:, 52] += 0.4
    cells = [",".join(f"{x:.10f}" for x in row) for row in table]
    rows = [f"00:00:00:{i:02d}.000,61,{row}" for i, row in enumerate(cells)]
    header = ",".join(("Timecode", "BlendShapeCount", *SHAPES, *HEAD, *EYES))
    (tmp_path / "app.csv").write_text("\n".join([header, *rows]) + "\n")
    for between in ("a.glb", "a.usdc"):
        mien("convert", tmp_path / "app.csv", output=tmp_path / between)
        mien("convert", tmp_path / between, output=tmp_path / "back.csv")
        back = read_live_link(tmp_path / "back.csv")
        np.testing.assert_allclose(back.weights, table[:, :52], atol=1e-4)
        np.testing.assert_allclose(back.head, table[:, 52:55], atol=1e-4)
        assert back.rate == 60
        mien("convert", tmp_path / "back.csv", output=tmp_path / between)
        mien("convert", tmp_path / between, output=tmp_path / "again.csv")
        np.testing.assert_allclose(read_live_link(tmp_path / "again.csv").eyes, back.eyes, atol=1e-4)
