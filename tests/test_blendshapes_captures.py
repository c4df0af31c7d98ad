"""What a session's folder holds."""

import numpy as np
import pytest
from PIL import Image

from mien.blendshapes.captures import capture_of_mesh, find_captures, neutral_of, with_picture_beside
from mien.errors import BadInput
from mien.mesh import Mesh, Scan

TRIANGLE = Mesh(np.eye(3), np.array([[0, 1, 2]]))


def test_captures_are_folders_recordings_meshes_and_maps(tmp_path):
    for name in ("smile.ply", "smile.exr", "smile.png", "jaw.r3d", ".hidden.ply", "notes.txt"):
        (tmp_path / name).write_text("")
    (tmp_path / "neutral" / "depth").mkdir(parents=True)
    (tmp_path / "neutral" / "depth" / "000000.png").write_text("")
    (tmp_path / "empty").mkdir()
    assert [path.name for path in find_captures(tmp_path)] == ["jaw.r3d", "neutral", "smile.exr"]
    with pytest.raises(BadInput, match="holds no capture"):
        find_captures(tmp_path / "empty")


def test_the_neutral_is_known_by_its_name_or_asked_for():
    assert neutral_of(["smile", "01_Neutral"]) == "01_Neutral"
    assert neutral_of(["james"]) == "james"
    assert neutral_of(["a", "b"], "b") == "b"
    with pytest.raises(BadInput, match="no capture is called neutral"):
        neutral_of(["a", "b"])
    with pytest.raises(BadInput, match="2 neutral captures"):
        neutral_of(["neutral1", "neutral2"])
    with pytest.raises(BadInput, match="no capture is called so"):
        neutral_of(["a"], "c")


def test_a_picture_beside_a_mesh_is_taken_when_one_is_meant(tmp_path):
    for name in ("Map-COL.png", "Map-SPEC.png"):
        Image.new("RGB", (4, 4), (255, 0, 0)).save(tmp_path / name)
    flat = Scan(Mesh(TRIANGLE.vertices, TRIANGLE.faces, np.zeros((3, 2))), name="head")
    found, notes = with_picture_beside(flat, tmp_path / "head.obj")
    assert found.texture is not None
    assert "Map-COL.png" in notes[0]
    (tmp_path / "Map-COL.png").rename(tmp_path / "Other.png")
    assert with_picture_beside(flat, tmp_path / "head.obj")[0].texture is None


def test_scans_without_colour_are_refused():
    with pytest.raises(BadInput, match="no texture and no vertex colours"):
        capture_of_mesh(Scan(TRIANGLE, name="grey"), 2.0)
    with pytest.raises(BadInput, match="no texture coordinates"):
        capture_of_mesh(Scan(TRIANGLE, np.zeros((2, 2, 3), np.uint8), "flat"), 2.0)
