"""Wavefront OBJ, however it is written."""

import re
import time

import numpy as np
import pytest
from PIL import Image

from mesh_files import SQUARE, TWO, refusal
from mien.io.meshes import read_scan, write_obj
from mien.mesh import Mesh


@pytest.mark.parametrize(
    "face", ["f 1 2 3 4", "f 1/1 2/2 3/3 4/4", "f 1//1 2//1 3//1 4//1", "f 1/1/1 2/2/1 3/3/1 4/4/1", "f -4 -3 -2 -1",
             "f 1/1 2 3/3/1 4//1", "f 1 2 \\\n 3 4", "f 1 2 3\r\nf 1 3 4"],
)  # fmt: skip
def test_obj_in_every_way_to_write_a_face(tmp_path, face):
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in SQUARE)
    texels = "".join(f"vt {x} {y}\n" for x, y, _ in SQUARE)
    (tmp_path / "a.obj").write_text(f"# a square\no square\n{vertices}{texels}vn 0 0 1\ng one\ns off\n{face}\n")
    mesh = read_scan(tmp_path / "a.obj").mesh
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.faces, TWO)
    if face.startswith("f 1/1 2/2") or face.startswith("f 1/1/1"):
        assert mesh.uv_faces is None
        np.testing.assert_array_equal(mesh.uv, SQUARE[:, :2])
    elif "/1 2 3/3" in face:
        assert mesh.uv is not None
        np.testing.assert_array_equal(mesh.uv[mesh.uv_faces[1]], [[0, 0], [1, 1], [0, 0]])  # pyright: ignore
    else:
        assert mesh.uv is None


def test_obj_with_relative_indices_in_two_parts(tmp_path):
    part = "v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf -3 -2 -1\n"
    (tmp_path / "a.obj").write_text(part.format(z=0) + part.format(z=5))
    np.testing.assert_array_equal(read_scan(tmp_path / "a.obj").mesh.faces, [[0, 1, 2], [3, 4, 5]])


def test_obj_keeps_unused_vertices_and_colours(tmp_path):
    lines = ["v 9 9 9 0.5 0.25 1", *(f"v {x} {y} {z} 1 0 0" for x, y, z in SQUARE), "f 2 3 4"]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    mesh = read_scan(tmp_path / "a.obj").mesh
    assert len(mesh.vertices) == 5
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors[:2], [[0.5, 0.25, 1], [1, 0, 0]])


def test_obj_finds_its_picture(tmp_path):
    body = "".join(f"v {x} {y} {z}\nvt {x} {y}\n" for x, y, z in SQUARE) + "usemtl b\nf 1/1 2/2 3/3\n"
    for name, level in (("first.png", 10), ("sub dir/second one.png", 20), ("a.png", 30)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        Image.new("RGB", (2, 2), (level, 0, 0)).save(tmp_path / name)
    materials = "newmtl a\nmap_Kd first.png\nnewmtl b\nmap_Kd sub dir\\second one.png\n"
    (tmp_path / "look.mtl").write_text(materials)
    (tmp_path / "a.obj").write_text("mtllib look.mtl\n" + body)
    scan = read_scan(tmp_path / "a.obj")
    assert scan.texture is not None
    assert scan.texture[0, 0, 0] == 20
    (tmp_path / "look.mtl").write_text(materials.replace("sub dir\\second one.png", "-s 1 1 1 gone.png"))
    assert read_scan(tmp_path / "a.obj").texture[0, 0, 0] == 10  # pyright: ignore[reportOptionalSubscript]
    (tmp_path / "look.mtl").unlink()
    assert read_scan(tmp_path / "a.obj").texture[0, 0, 0] == 30  # pyright: ignore[reportOptionalSubscript]
    (tmp_path / "a.png").unlink()
    assert read_scan(tmp_path / "a.obj").texture is None
    (tmp_path / "a.png").write_text("this is no picture")
    assert "no picture" in refusal(tmp_path / "a.obj")


def test_obj_is_read_fast(tmp_path):
    """40k vertices with texture coordinates; 0.3 s on a quiet machine, and the bound leaves room for a busy one."""
    n = 40_000
    rng = np.random.default_rng(0)
    faces = rng.integers(0, n, (2 * n, 3))
    mesh = Mesh(rng.normal(0, 60, (n, 3)), faces, rng.random((n, 2)), faces[:, ::-1].copy())
    write_obj(tmp_path / "big.obj", mesh)
    start = time.process_time()
    read = read_scan(tmp_path / "big.obj").mesh
    assert time.process_time() - start < 2
    np.testing.assert_array_equal(read.faces, faces)
    np.testing.assert_array_equal(read.uv_faces, faces[:, ::-1])
    np.testing.assert_allclose(read.vertices, mesh.vertices, atol=1e-6)


def test_obj_refusals(tmp_path):
    path = tmp_path / "a.obj"
    assert "no such file" in refusal(path)
    assert "is empty" in refusal(path, "")
    assert "no triangles" in refusal(path, "v 0 0 0\nv 1 0 0\n")
    assert "fewer than 3 numbers" in refusal(path, "v 0 0 0\nv 1 0\nf 1 2 1\n")
    assert "names v number 7, but there are 2" in refusal(path, "v 0 0 0\nv 1 0 0\nf 1 2 7\n")
    assert "no sound OBJ: a" in refusal(path, "v 0 0 zero\nf 1 1 1\n")
    assert "no sound OBJ: a" in refusal(path, "v 0 0 0\nf 1 1 one\n")
    assert "not finite, the first is number 1" in refusal(path, "v 0 0 0\nv 0 nan 0\nf 1 2 1\n")
    assert "binary" in refusal(path, b"\0\1\2\3" * 40)
    assert "names v number 0" in refusal(path, "v 0 0 0\nf 0 1 1\n")
    assert "names v number 0" in refusal(path, "v 0 0 0\nvt 0 0\nf /1 1/1 1/1\n")
    assert "names vt number 2" in refusal(path, "v 0 0 0\nvt 0 0\nf 1/1 1/1 1/2\n")


TRIANGLE = "v 0{0}5 1{0}25 -2{0}0\nv 3{0}0 1{0}0 0{0}0\nv 0{0}0 4{0}5 1{0}0\nf 1 2 3\n"


def test_decimal_commas_are_points(tmp_path):
    (tmp_path / "a.obj").write_text(TRIANGLE.format(","))
    mesh = read_scan(tmp_path / "a.obj").mesh
    np.testing.assert_array_equal(mesh.vertices, [[0.5, 1.25, -2], [3, 1, 0], [0, 4.5, 1]])
    (tmp_path / "b.obj").write_text("v 1. 2. 3. 1\nv 4. 2. 3. 1\nv 4. 7. 3. 1\nf 1 2 3\n")
    np.testing.assert_array_equal(read_scan(tmp_path / "b.obj").mesh.vertices, [[1, 2, 3], [4, 2, 3], [4, 7, 3]])


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (TRIANGLE.format(". "), r"decimals are parted by blanks \(v 0\. 5 1\. 25 -2\. 0\)"),
        ("v 0 1098600 1 0 2 450000\n" * 3 + "f 1 2 3\n", "numbers from 0 to 450000 behind x y z, which are no colours"),
    ],
)
def test_decimals_that_were_torn_off_are_no_colours(tmp_path, text, why):
    assert re.search(why, refusal(tmp_path / "a.obj", text))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_byte_order_mark_costs_no_vertex(tmp_path, encoding):
    (tmp_path / "a.obj").write_text("v 5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding=encoding)
    np.testing.assert_array_equal(read_scan(tmp_path / "a.obj").mesh.vertices[0], [5, 0, 0])


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_and_wide_letters(tmp_path, encoding, end):
    lines = [f"v {x} {y} {z}" for x, y, z in SQUARE] + ["v 1.#QNAN -1.#IND 0 # lost", "f 1 2 3 4", ""]
    for name in (encoding, "utf-8"):
        (tmp_path / "a.obj").write_bytes(end.join(lines).encode(name))
        mesh = read_scan(tmp_path / "a.obj").mesh
        np.testing.assert_array_equal(mesh.vertices, SQUARE)
        np.testing.assert_array_equal(mesh.faces, TWO)
