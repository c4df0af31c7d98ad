"""Rigs from folders of meshes."""

import numpy as np
import pytest

from gltf_files import rig, same_rig
from mesh_files import bumpy
from mien.errors import BadInput
from mien.io.gltf import write_rig
from mien.io.meshes import write_mesh
from mien.io.rigs import read_any_rig
from mien.mesh import Mesh


def folder_of(path, suffix: str, scale: float = 1.0):
    mesh = bumpy(uv="corner")
    texture = np.random.default_rng(0).integers(0, 256, (3, 3, 3), dtype=np.uint8)
    rng = np.random.default_rng(9)
    path.mkdir(exist_ok=True)
    deltas = {name: rng.normal(0, 2, mesh.vertices.shape) for name in ("smile", "jawOpen")}
    write_mesh(path / f"Neutral_01{suffix}", mesh.with_vertices(mesh.vertices * scale), texture)
    for name, delta in deltas.items():
        write_mesh(path / f"{name}{suffix}", mesh.with_vertices((mesh.vertices + delta) * scale))
    (path / "readme.txt").write_text("not a mesh")
    (path / "._smile.obj").write_text("not a mesh either")
    return mesh, deltas, texture


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
def test_a_folder_is_a_rig(tmp_path, suffix):
    mesh, deltas, texture = folder_of(tmp_path / "rig", suffix)
    read = read_any_rig(tmp_path / "rig")
    assert read.names == ("jawOpen", "smile")
    np.testing.assert_allclose(read.neutral.vertices, mesh.vertices, atol=1e-5)
    np.testing.assert_array_equal(read.neutral.faces, mesh.faces)
    np.testing.assert_allclose(read.deltas[0], deltas["jawOpen"], atol=3e-5)
    np.testing.assert_array_equal(read.texture, texture)


def test_a_folder_in_centimetres(tmp_path):
    mesh, _, _ = folder_of(tmp_path / "rig", ".ply", scale=0.1)
    np.testing.assert_allclose(read_any_rig(tmp_path / "rig", unit="cm").neutral.vertices, mesh.vertices, atol=1e-4)


@pytest.mark.parametrize(("unit", "scale"), [("m", 0.001), ("cm", 0.1)])
def test_a_folder_settles_its_unit_and_says_so(tmp_path, unit, scale):
    mesh, _, _ = folder_of(tmp_path / "rig", ".ply", scale=scale)
    told = []
    read = read_any_rig(tmp_path / "rig", tell=told.append)
    np.testing.assert_allclose(read.neutral.vertices, mesh.vertices, atol=1e-3)
    assert len(told) == 1
    assert f"read as {unit}" in told[0]


def test_a_glb_is_a_rig(tmp_path):
    write_rig(tmp_path / "rig.glb", rig())
    same_rig(read_any_rig(tmp_path / "rig.glb"), rig())


def test_refusals(tmp_path):
    def line() -> str:
        with pytest.raises(BadInput) as caught:
            read_any_rig(tmp_path / "rig")
        assert "\n" not in str(caught.value)
        return str(caught.value)

    assert "no such file" in line()
    mesh, _, _ = folder_of(tmp_path / "rig", ".obj")
    short = Mesh(mesh.vertices[:-1], np.array([[0, 1, 2]]))
    write_mesh(tmp_path / "rig/smile.obj", short)
    write_mesh(tmp_path / "rig/jawOpen.obj", short)
    assert "jawOpen.obj: has 39 vertices, Neutral_01.obj 40" in line()
    write_mesh(tmp_path / "rig/smile.ply", mesh)
    assert "two meshes of one name" in line()
    write_mesh(tmp_path / "rig/neutral.ply", mesh)
    assert "exactly one" in line()
    for file in (tmp_path / "rig").glob("*eutral*"):
        file.unlink()
    assert "named neutral, has jawOpen.obj" in line()
    for file in (tmp_path / "rig").glob("*"):
        file.unlink()
    write_mesh(tmp_path / "rig/neutral.ply", mesh)
    assert "no mesh beside neutral.ply" in line()
    with pytest.raises(BadInput, match="is no rig"):
        read_any_rig(tmp_path / "rig/neutral.ply")


@pytest.mark.parametrize("name", ["00_neutral", "faceNeutral", "NEUTRAL", "Basis", "head_base", "rest", "bindPose"])
def test_the_neutral_by_any_word_that_says_so(tmp_path, name):
    mesh, _, _ = folder_of(tmp_path / "rig", ".obj")
    (tmp_path / "rig/Neutral_01.obj").rename(tmp_path / f"rig/{name}.obj")
    read = read_any_rig(tmp_path / "rig")
    assert read.names == ("jawOpen", "smile")
    np.testing.assert_allclose(read.neutral.vertices, mesh.vertices, atol=1e-5)


def test_one_bad_mesh_is_named_and_left_out(tmp_path):
    folder_of(tmp_path / "rig", ".obj")
    (tmp_path / "rig/a.obj").write_text("hello")
    (tmp_path / "rig/z.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    told = []
    assert read_any_rig(tmp_path / "rig", tell=told.append).names == ("jawOpen", "smile")
    for line, name in zip(told, "az", strict=True):
        assert line.startswith(f"left out: {tmp_path}/rig/{name}.obj: ")
