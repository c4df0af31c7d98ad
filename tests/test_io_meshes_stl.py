"""STL, text and binary."""

import numpy as np
import pytest
import trimesh

from mesh_files import SQUARE, TWO, refusal
from mien.io.meshes import read_scan


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_stl_from_trimesh(tmp_path, kind):
    box = trimesh.creation.icosphere(2, radius=80)
    box.export(tmp_path / "a.stl", file_type=kind)
    mesh = read_scan(tmp_path / "a.stl").mesh
    assert len(mesh.vertices) == len(box.vertices)
    np.testing.assert_allclose(mesh.vertices[mesh.faces], box.vertices[box.faces], atol=1e-4)


def test_stl_refusals(tmp_path):
    path = tmp_path / "a.stl"
    trimesh.creation.box().export(path)
    data = path.read_bytes()
    assert "cut off" in refusal(path, data[:-1])
    assert "no triangles" in refusal(path, data[:80] + bytes(4)) or "no vertices" in refusal(path)
    assert "not an STL" in refusal(path, b"hello")
    signalling = bytes.fromhex("0100807f")
    assert "not finite" in refusal(path, data[:96] + signalling + data[100:])
    trimesh.creation.box().export(path, file_type="stl_ascii")
    text = path.read_bytes()
    assert "cut off" in refusal(path, text[: len(text) // 2])
    assert "damaged" in refusal(path, text.replace(b"vertex 0.5", b"vertex zero"))


@pytest.mark.parametrize("spelled", [str.upper, str.lower, "\ufeff{}".format, lambda text: text.replace("\n", "\r")])
def test_text_in_capitals_behind_a_mark_or_with_other_line_ends(tmp_path, spelled):
    corners = "".join(f"vertex {x:.1e} {y} {z}\n" for x, y, z in SQUARE[TWO[0]])
    (tmp_path / "a.stl").write_text(spelled(f"solid a\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendsolid a\n"))
    np.testing.assert_array_equal(read_scan(tmp_path / "a.stl").mesh.vertices, SQUARE[:3])
