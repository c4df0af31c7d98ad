"""Headers of PLY files, whatever ends their lines and however they are spelled."""

from pathlib import Path

import numpy as np
import pytest

from mesh_files import SQUARE, TWO
from mien.errors import BadInput
from mien.io.meshes import read_scan
from mien.io.meshes.ply_header import read_ply_header

TEXT = (
    "ply\nformat ascii 1.0\ncomment TextureFile my face.png\nelement vertex 4\n"
    "property float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    + "".join(f"{x} {y} {z}\n" for x, y, z in SQUARE)
    + "".join(f"3 {a} {b} {c}\n" for a, b, c in TWO)
)


def test_a_header_by_hand():
    data = TEXT.encode()
    header = read_ply_header(Path("a.ply"), data)
    assert [(e.name, e.size, [p.name for p in e.properties]) for e in header.elements] == [
        ("vertex", 4, ["x", "y", "z"]),
        ("face", 2, ["vertex_indices"]),
    ]
    assert (header.end, header.pictures) == ("", ["my face.png"])
    assert data[header.body :].startswith(b"0.0 0.0")


@pytest.mark.parametrize(
    ("old", "new"),
    [("\n", "\r\n"), ("\n", "\r"), ("ply", "\ufeffply"), ("ascii", "ASCII"), ("uchar int", "uint8 int64"),
     ("end_header\n", "end_header \n"), ("comment Texture", "comment texture")],
)  # fmt: skip
def test_every_spelling_gives_the_same_mesh(tmp_path, old, new):
    (tmp_path / "a.ply").write_bytes(TEXT.replace(old, new).encode())
    mesh = read_scan(tmp_path / "a.ply").mesh
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.faces, TWO)


def test_binary_rows_may_begin_with_a_byte_that_ends_lines(tmp_path):
    """The first byte of the rows is a line feed, and the header's lines end in carriage returns."""
    head = TEXT[: TEXT.index("end_header") + len("end_header\n")].replace("ascii", "binary_little_endian")
    points = SQUARE.astype("<f4")
    points[0, 0] = np.frombuffer(b"\n\0\0\0", "<f4")[0]
    rows = points.tobytes() + b"".join(b"\3" + face.astype("<i4").tobytes() for face in TWO)
    for end in ("\n", "\r"):
        (tmp_path / "a.ply").write_bytes(head.replace("\n", end).encode() + rows)
        np.testing.assert_array_equal(read_scan(tmp_path / "a.ply").mesh.vertices, points)


@pytest.mark.parametrize("data", [b"", b"plyx", b"solid\nend_header\n", b"ply\nelement vertex many\nend_header\n"])
def test_what_is_no_header_is_one_line(data):
    with pytest.raises(BadInput, match="PLY"):
        read_ply_header(Path("a.ply"), data)
