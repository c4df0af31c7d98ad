"""`mien register SCANS/`: what is wrong is told; what is left goes to a rig that `mien solve` takes up."""

import json
from dataclasses import replace

import pytest

from command import mien
from face_model import needs_model
from mien.errors import BadInput
from mien.io.gltf import read_performance, read_rig
from mien.io.markers import write_c3d
from mien.io.meshes import write_mesh
from scan_stage import FRAMES, QUICK, scan_stage


def test_the_command_tells_what_is_wrong(tmp_path, monkeypatch):
    monkeypatch.setattr("mien.cli.register.require_landmarker", lambda: None)
    _, take, _, scans = scan_stage()
    folder = tmp_path / "scans"
    folder.mkdir()
    for staged in scans[:2]:
        write_mesh(folder / f"{staged.scan.name}.ply", staged.scan.mesh)
    write_c3d(tmp_path / "take.c3d", take.markers)
    (tmp_path / "selection.json").write_text(json.dumps({"frames": list(FRAMES)}))
    files = {"markers": "take.c3d", "selection": "selection.json", "output": "face.glb"}
    given = {name: tmp_path / file for name, file in files.items()}
    with pytest.raises(BadInput, match="selected frame 110: it has no scan"):
        mien("register", folder, **given, strict=True)
    with pytest.raises(BadInput, match="a folder; its scans need the take"):
        mien("register", folder, output=tmp_path / "face.glb")
    with pytest.raises(BadInput, match="--markers does nothing for one scan"):
        mien("register", folder / "s_010.ply", **given)
    (folder / "s_070.ply").rename(folder / "s_071.ply")
    with pytest.raises(BadInput, match=r"1 scan.s. of selected frames can be used.*frame 71 is not among the selected"):
        mien("register", folder, **given)
    assert not (tmp_path / "face.glb").exists()


@needs_model
def test_the_command_leaves_a_rig_that_solve_takes_up(tmp_path, monkeypatch, capsys):
    _, take, _, scans = scan_stage()
    folder = tmp_path / "scans"
    folder.mkdir()
    for staged in scans[:2]:
        write_mesh(folder / f"{staged.scan.name}.ply", staged.scan.mesh)
    write_c3d(tmp_path / "take.c3d", take.markers)
    (tmp_path / "selection.json").write_text(json.dumps({"frames": list(FRAMES)}))
    quick = replace(QUICK, fine=replace(QUICK.fine, sweeps=0))
    monkeypatch.setattr("mien.scans.pipeline.ScansConfig", lambda: quick)
    mien(
        "register",
        folder, output=tmp_path / "face.glb", markers=tmp_path / "take.c3d", selection=tmp_path / "selection.json",
        density=0,
    )  # fmt: skip
    rig = read_rig(tmp_path / "face.glb")
    assert rig.names == ("s_070",)
    record = json.loads((tmp_path / "face.register.json").read_text())
    assert set(record["scans"]) == {"s_010", "s_070"}
    assert (tmp_path / "face.html").stat().st_size > 10_000
    mien("solve", tmp_path / "take.c3d", rig=tmp_path / "face.glb", output=tmp_path / "perf.glb")
    performance = read_performance(tmp_path / "perf.glb")
    jaw = performance.weights[:, 0]
    assert jaw[70] > 0.8 > 0.2 > jaw[10]
    told = capsys.readouterr().out
    assert "left out: selected frame 110: it has no scan" in told
    assert "2 scans" in told
