"""Scans: hand-written files, round trips, other readers' opinion, and every refusal with its line."""

import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from mien.errors import BadInput
from mien.io.gltf import write_rig
from mien.io.meshes import read_scan, write_mesh, write_obj, write_ply
from mien.io.meshes.polygons import fan, weld
from mien.mesh import Mesh
from test_io_gltf import foreign, rig

REAL = Path(__file__).resolve().parents[2] / "shared/data"

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def refusal(path: Path, content: str | bytes | None = None) -> str:
    if content is not None:
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(BadInput) as caught:
        read_scan(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def bumpy(n: int = 40, colors: bool = False, uv: str = "none") -> Mesh:
    rng = np.random.default_rng(2)
    vertices = rng.normal(0, 60, (n, 3))
    faces = np.array([rng.permutation(n)[:3] for _ in range(2 * n)])
    options: dict = {"colors": rng.integers(0, 256, (n, 3)) / 255.0} if colors else {}
    if uv == "vertex":
        options["uv"] = rng.random((n, 2))
    if uv == "corner":
        options |= {"uv": rng.random((n + 7, 2)), "uv_faces": rng.integers(0, n + 7, (2 * n, 3))}
    return Mesh(vertices, faces, **options)


# --- pieces ------------------------------------------------------------------------------------------------------


def test_fan_by_hand():
    np.testing.assert_array_equal(fan(np.array([3, 4, 2, 5])), [
        [0, 1, 2], [3, 4, 5], [3, 5, 6], [9, 10, 11], [9, 11, 12], [9, 12, 13],
    ])  # fmt: skip


def test_weld_keeps_first_met_order():
    rows = np.array([[2.0, 0], [1, 1], [2, -0.0], [0, 0], [1, 1]])
    np.testing.assert_array_equal(weld(rows), [0, 1, 0, 2, 1])


# --- OBJ ---------------------------------------------------------------------------------------------------------


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


# --- PLY ---------------------------------------------------------------------------------------------------------

HEADER = """ply
format {format} 1.0
comment by hand
element vertex 4
property double x
property double y
property double z
property uchar red
property uchar green
property uchar blue
element face {faces}
property list uchar int vertex_indices
end_header
"""


def hand_ply(path: Path, end: str, polygons: list[list[int]]) -> Path:
    name = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[end]
    head = HEADER.format(format=name, faces=len(polygons)).encode()
    if end == "":
        rows = [f"{x} {y} {z} 255 0 51" for x, y, z in SQUARE] + [" ".join(map(str, [len(p), *p])) for p in polygons]
        path.write_bytes(head + "\n".join(rows).encode())
    else:
        vertices = b"".join(v.astype(end + "f8").tobytes() + bytes([255, 0, 51]) for v in SQUARE)
        faces = b"".join(bytes([len(p)]) + np.array(p, end + "i4").tobytes() for p in polygons)
        path.write_bytes(head + vertices + faces)
    return path


@pytest.mark.parametrize("end", ["<", ">", ""])
@pytest.mark.parametrize("polygons", [TWO.tolist(), [[0, 1, 2, 3]], [*TWO.tolist(), [0, 1, 2, 3], [0, 1]]])
def test_ply_by_hand(tmp_path, end, polygons):
    mesh = read_scan(hand_ply(tmp_path / "a.ply", end, polygons)).mesh
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.faces[:2], TWO)
    assert len(mesh.faces) == sum(max(len(p) - 2, 0) for p in polygons)
    np.testing.assert_allclose(mesh.colors, np.tile([1, 0, 0.2], (4, 1)))


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


def test_ply_refusals(tmp_path):
    path = tmp_path / "a.ply"
    assert "not a PLY file" in refusal(path, "")
    assert "not a PLY file" in refusal(path, "plywood\n")
    assert "not a PLY file" in refusal(path, HEADER[:60])
    for end in ("<", ">", ""):
        for polygons in (TWO.tolist(), [[0, 1, 2], [0, 1, 2, 3]]):
            whole = hand_ply(path, end, polygons).read_bytes()
            assert "cut off" in refusal(path, whole[:-7])
            assert "cut off" in refusal(path, whole[: whole.index(b"end_header") + 40])
    assert "no triangles" in refusal(hand_ply(path, "<", []))
    assert "names vertex 9" in refusal(hand_ply(path, "<", [[0, 1, 9]]))
    assert "header line" in refusal(path, HEADER.format(format="klingon", faces=0))
    assert "x, y, z" in refusal(path, "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n")
    assert "damaged" in refusal(path, hand_ply(path, "", [[0, 1, 2]]).read_bytes().replace(b"0.0", b"0.o"))
    mesh = bumpy()
    mesh.vertices[3, 1] = np.inf
    write_ply(path, mesh)
    assert "not finite" in refusal(path)


# --- STL and GLB -------------------------------------------------------------------------------------------------


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
    trimesh.creation.box().export(path, file_type="stl_ascii")
    text = path.read_bytes()
    assert "cut off" in refusal(path, text[: len(text) // 2])
    assert "damaged" in refusal(path, text.replace(b"vertex 0.5", b"vertex zero"))


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


# --- real scans --------------------------------------------------------------------------------------------------


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


def test_a_row_of_text_ply_may_hold_more_than_its_header_names(tmp_path):
    """Exporters add texture coordinates and colours to face lines that the header does not count."""
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1 255\n3 0 2 3 6 0 0 1 1 0 1 255\n"
    (tmp_path / "a.ply").write_text(head + body)
    assert read_scan(tmp_path / "a.ply").mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    (tmp_path / "a.ply").write_text(head + body.replace("3 0 2 3 6 0 0 1 1 0 1 255\n", "3 0 2\n"))
    with pytest.raises(BadInput, match="too short"):
        read_scan(tmp_path / "a.ply")


def test_a_vertex_that_is_not_finite_goes_where_no_face_uses_it(tmp_path):
    text = "v 0 0 0\nv nan nan nan\nv 1 0 0\nv 0 1 0\nf 1 3 4\n"
    (tmp_path / "a.obj").write_text(text)
    mesh = read_scan(tmp_path / "a.obj").mesh
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert np.isfinite(mesh.vertices).all()
    (tmp_path / "a.obj").write_text(text.replace("f 1 3 4", "f 1 2 4"))
    with pytest.raises(BadInput, match="not finite"):
        read_scan(tmp_path / "a.obj")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_byte_order_mark_costs_no_vertex(tmp_path, encoding):
    (tmp_path / "a.obj").write_text("v 5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding=encoding)
    np.testing.assert_array_equal(read_scan(tmp_path / "a.obj").mesh.vertices[0], [5, 0, 0])
