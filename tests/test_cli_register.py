"""`mien register SCANS/`: what is wrong is told in one line, before the work."""

import json

import numpy as np
import pytest

from command import mien
from mien.cli.register import beside_arkit, kept_before, write_completed
from mien.errors import BadInput
from mien.faces import ARKIT_NAMES, load_face
from mien.io.gltf import read_rig
from mien.io.markers import write_c3d
from mien.io.meshes import write_mesh
from mien.rig import Rig
from scan_stage import FRAMES, scan_stage


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
    with pytest.raises(BadInput, match=r"1 scan of selected frames can be used.*frame 71 is not among the selected"):
        mien("register", folder, **given)
    assert not (tmp_path / "face.glb").exists()


def test_a_rig_of_scans_is_written_with_the_52_too(tmp_path, monkeypatch):
    face = load_face()
    asked = []

    def same_triangles(source, target):
        asked.append(target)
        return np.arange(len(target.neutral.faces))

    monkeypatch.setattr("mien.landmarks.face_correspondence.match_faces", same_triangles)
    jaw = face.rig.deltas[[face.rig.index("jawOpen")]]
    scanned = Rig(face.rig.neutral, 0.8 * jaw, ("frame_000012",))
    path = beside_arkit(tmp_path / "face.glb")
    assert path.name == "face.arkit.glb"
    write_completed(path, scanned)
    assert asked == [scanned]
    assert read_rig(path).names == (*ARKIT_NAMES, "frame_000012")
    write_mesh(tmp_path / "one.ply", face.rig.neutral)
    with pytest.raises(BadInput, match="--arkit does nothing for one scan"):
        mien("register", tmp_path / "one.ply", output=tmp_path / "out.glb", arkit=True)


def test_what_a_rerun_replaces_is_kept_beside(tmp_path):
    face = tmp_path / "face.glb"
    assert kept_before(face) is None
    face.write_bytes(b"old")
    assert kept_before(face) == tmp_path / "face.before.glb"
    assert (tmp_path / "face.before.glb").read_bytes() == b"old"
