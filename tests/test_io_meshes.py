"""Scans: hand-written files, round trips, other readers' opinion, and every refusal with its line."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from gltf_files import foreign, rig
from mesh_files import bumpy, refusal
from mien.errors import BadInput
from mien.io.gltf import write_rig
from mien.io.meshes import read_scan, write_mesh, write_obj, write_ply

REAL = Path(__file__).resolve().parents[2] / "shared/data"


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
@pytest.mark.parametrize("colors", [False, True])
@pytest.mark.parametrize("uv", ["none", "vertex", "corner"])
def test_round_trip(tmp_path, suffix, colors, uv):
    mesh = bumpy(colors=colors, uv=uv)
    texture = np.random.default_rng(0).integers(0, 256, (4, 6, 3), dtype=np.uint8) if uv != "none" else None
    write_mesh(tmp_path / f"smile{suffix}", mesh, texture)
    scan = read_scan(tmp_path / f"smile{suffix}")
    assert scan.name == "smile"
    np.testing.assert_allclose(scan.mesh.vertices, mesh.vertices, rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(scan.mesh.faces, mesh.faces)
    if colors:
        np.testing.assert_allclose(scan.mesh.colors, mesh.colors, atol=1e-6)  # pyright: ignore
    if mesh.uv is not None:
        old = mesh.uv[mesh.faces if mesh.uv_faces is None else mesh.uv_faces]
        faces = scan.mesh.faces if scan.mesh.uv_faces is None else scan.mesh.uv_faces
        np.testing.assert_allclose(scan.mesh.uv[faces], old, atol=1e-6)  # pyright: ignore[reportOptionalSubscript]
        np.testing.assert_array_equal(scan.texture, texture)


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_trimesh_agrees_on_what_we_write(tmp_path, suffix):
    mesh = bumpy(colors=True)
    write_mesh(tmp_path / f"a{suffix}", mesh)
    other = trimesh.load_mesh(tmp_path / f"a{suffix}", process=False)
    np.testing.assert_allclose(other.vertices, mesh.vertices, rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(other.faces, mesh.faces)
    assert mesh.colors is not None
    np.testing.assert_allclose(other.visual.vertex_colors[:, :3] / 255, mesh.colors, atol=0.003)


def test_glb_scan_from_our_rig_and_from_trimesh(tmp_path):
    face = rig(texture=np.full((4, 4, 3), 99, np.uint8))
    write_rig(tmp_path / "face.glb", face)
    scan = read_scan(tmp_path / "face.glb")
    np.testing.assert_allclose(scan.mesh.vertices, face.neutral.vertices, atol=1e-5)
    np.testing.assert_array_equal(scan.mesh.faces, face.neutral.faces)
    np.testing.assert_array_equal(scan.texture, face.texture)
    ball = trimesh.creation.icosphere(2, radius=0.08)
    ball.export(tmp_path / "ball.glb")
    mesh = read_scan(tmp_path / "ball.glb").mesh
    np.testing.assert_allclose(mesh.vertices[mesh.faces], ball.vertices[ball.faces] * 1000, atol=1e-4)


def test_glb_scan_is_all_that_the_scene_shows(tmp_path):
    scan = read_scan(foreign(tmp_path / "a.glb"))
    assert len(scan.mesh.vertices) == 10
    read = read_scan(tmp_path / "a.glb", unit="cm").mesh.vertices
    np.testing.assert_allclose(read, scan.mesh.vertices / 100)


def test_units_and_suffixes(tmp_path):
    write_ply(tmp_path / "a.ply", bumpy())
    np.testing.assert_allclose(read_scan(tmp_path / "a.ply", unit="cm").mesh.vertices, bumpy().vertices * 10, rtol=1e-6)
    scaled = read_scan(tmp_path / "a.ply", unit="2.5").mesh.vertices
    np.testing.assert_allclose(scaled, bumpy().vertices * 2.5, rtol=1e-6)
    with pytest.raises(BadInput, match="expected mm, cm, m, in"):
        read_scan(tmp_path / "a.ply", unit="ell")
    assert ".obj .ply .stl .glb" in refusal(tmp_path / "a.fbx", "x")
    with pytest.raises(BadInput, match=r"use \.obj or \.ply"):
        write_mesh(tmp_path / "a.stl", bumpy())
    with pytest.raises(BadInput, match="does not exist"):
        write_obj(tmp_path / "none" / "a.obj", bumpy())


@pytest.mark.data
@pytest.mark.parametrize(
    ("file", "vertices", "faces", "textured"),
    [
        ("james/james.obj", 6393, 12228, True),
        ("lee_perry_smith/LeePerrySmith.obj", 8838, 17672, False),
        ("meshmonk/demoFace_full.obj", 25524, 50660, False),
        ("meshmonk/Template.obj", 7160, 14050, False),
    ],
)
def test_real_scans_as_trimesh_reads_them(file, vertices, faces, textured):
    path = REAL / file
    if not path.exists():
        pytest.skip(f"{path} is not there")
    scan = read_scan(path)
    assert (len(scan.mesh.vertices), len(scan.mesh.faces)) == (vertices, faces)
    assert (scan.texture is not None) == textured
    other = trimesh.load_mesh(path, process=False, maintain_order=True)
    np.testing.assert_allclose(scan.mesh.vertices[scan.mesh.faces], other.vertices[other.faces], atol=1e-6)


def test_a_vertex_that_is_not_finite_goes_where_no_face_uses_it(tmp_path):
    text = "v 0 0 0\nv nan nan nan\nv 1 0 0\nv 0 1 0\nf 1 3 4\n"
    (tmp_path / "a.obj").write_text(text)
    mesh = read_scan(tmp_path / "a.obj").mesh
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert np.isfinite(mesh.vertices).all()
    (tmp_path / "a.obj").write_text(text.replace("f 1 3 4", "f 1 2 4"))
    with pytest.raises(BadInput, match="not finite"):
        read_scan(tmp_path / "a.obj")
