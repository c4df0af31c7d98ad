"""PLY, text and binary."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mesh_files import SQUARE, TWO, bumpy, refusal
from mien.errors import BadInput
from mien.io.meshes import read_scan, write_ply

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


def test_pages_go_by_each_faces_number(tmp_path):
    for name, color in (("red.png", (255, 0, 0)), ("blue.png", (0, 0, 255))):
        Image.new("RGB", (2, 2), color).save(tmp_path / name)
    corners = ["3 0 1 2 6 0 0 1 0 1 1 0", "3 0 2 3 6 0 0 1 1 0 1 1"]
    rows = [*(f"{x} {y} {z}" for x, y, z in SQUARE), *corners]
    head = [
        "ply", "format ascii 1.0", "comment TextureFile red.png", "comment TextureFile blue.png",
        "element vertex 4", *(f"property float {axis}" for axis in "xyz"), "element face 2",
        "property list uchar int vertex_indices", "property list uchar float texcoord", "property int texnumber",
        "end_header",
    ]  # fmt: skip
    (tmp_path / "a.ply").write_text("\n".join([*head, *rows]) + "\n")
    scan = read_scan(tmp_path / "a.ply")
    np.testing.assert_array_equal(scan.texture[:, 0], [[255, 0, 0]] * 2 + [[0, 0, 255]] * 2)
    heights = scan.mesh.uv[scan.mesh.uv_faces][..., 1]
    np.testing.assert_allclose([heights[0].min(), heights[1].max()], 0.5)


def test_strips_are_triangles(tmp_path):
    head = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {axis}" for axis in "xyz")]
    head += ["element tristrips 1", "property list int int vertex_indices", "end_header"]
    rows = [*(f"{x} {y} {z}" for x, y, z in SQUARE), "4 1 2 0 3"]
    (tmp_path / "a.ply").write_text("\n".join([*head, *rows]) + "\n")
    np.testing.assert_array_equal(read_scan(tmp_path / "a.ply").mesh.faces, [[1, 2, 0], [0, 2, 3]])


def test_a_missing_vertex_is_told_where_the_numbers_happen_to_suffice(tmp_path):
    """Five vertices promised, four there: 15 numbers of vertices and three faces of two corners would fit as well."""
    head = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 3\nproperty list uchar int vertex_indices\nend_header\n"
    body = "0 0 0\n10 0 0\n0 10 0\n0 0 10.5\n3 0 1 2\n3 0 1 3\n3 1 2 3\n"
    assert "is cut off: it has fewer than the 3 rows of face" in refusal(tmp_path / "a.ply", head + body)
    (tmp_path / "b.ply").write_text(head.replace("vertex 5", "vertex 4") + body.replace("\n", " ", 3))
    assert len(read_scan(tmp_path / "b.ply").mesh.faces) == 3
