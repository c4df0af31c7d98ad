"""What a session's folder holds."""

import numpy as np
import pytest
from PIL import Image

from mien.blendshapes import captures
from mien.blendshapes.build.masks import mask_textures
from mien.blendshapes.captures import capture_of_mesh, find_captures, neutral_of, with_picture_beside
from mien.errors import BadInput
from mien.faces import load_face
from mien.landmarks.detector import bundled_landmarks
from mien.landmarks.lift import Landmarks3D
from mien.mesh import Mesh, Scan
from mien.transforms import Transform

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


def painted_head(folder, upside_down: bool):
    """The bundled face's colours as a picture beside it, its landmarks known."""
    mesh = load_face().rig.neutral
    masks = {name: mesh.colors[:, i] for i, name in enumerate("rgb")}
    drawn = np.stack([mask_textures(mesh, masks, 128)[name] for name in "rgb"], -1)
    picture = (drawn * 255).astype(np.uint8)
    Image.fromarray(picture[::-1] if upside_down else picture).save(folder / "Map-COL.png")
    Image.new("RGB", (4, 4)).save(folder / "Map-SPEC.png")
    return Scan(Mesh(mesh.vertices, mesh.faces, mesh.uv, mesh.uv_faces), name="head")


@pytest.mark.parametrize("upside_down", [False, True])
def test_the_picture_beside_a_mesh_is_taken_the_right_way_up(upside_down, tmp_path, monkeypatch):
    head = painted_head(tmp_path, upside_down)
    points = bundled_landmarks().attachment.points(head.mesh)
    nothing = np.zeros(len(points))
    found = Landmarks3D(points, nothing, Transform.identity(), "mm", {}, 0.0, False)
    monkeypatch.setattr(captures, "lift_landmarks", lambda scan: found)
    taken, notes = with_picture_beside(head, tmp_path / "head.obj")
    assert "Map-COL.png" in notes[0]
    assert ("upside down" in notes[0]) == upside_down
    (tmp_path / "Map-COL.png").rename(tmp_path / "Other.png")
    assert with_picture_beside(head, tmp_path / "head.obj")[0].texture is None
    assert taken.texture is not None


def test_scans_without_colour_are_refused():
    with pytest.raises(BadInput, match="no texture and no vertex colours"):
        capture_of_mesh(Scan(TRIANGLE, name="grey"), 2.0)
    with pytest.raises(BadInput, match="no texture coordinates"):
        capture_of_mesh(Scan(TRIANGLE, np.zeros((2, 2, 3), np.uint8), "flat"), 2.0)
