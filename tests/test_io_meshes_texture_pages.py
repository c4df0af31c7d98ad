import numpy as np
import pytest
from PIL import Image

from mien.errors import BadInput
from mien.io.meshes import read_scan
from mien.io.meshes.texture_pages import on_pages, page_sizes, read_pages

RED, BLUE = (255, 0, 0), (0, 0, 255)


def two_pages(folder):
    """Two quads, each of a material of its own; pages of different sizes."""
    Image.new("RGB", (8, 4), RED).save(folder / "one.png")
    Image.new("RGB", (4, 6), BLUE).save(folder / "two page.png")
    (folder / "a.mtl").write_text("newmtl a\nmap_Kd one.png\nnewmtl b\nmap_Kd two page.png\nnewmtl c\nKd 1 1 1\n")
    (folder / "a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        "usemtl a\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 2/1 5/2 6/3 3/4\n"
    )


def colour_at(scan, triangle):
    """The texture's colour in the middle of a triangle."""
    u, v = scan.mesh.uv[scan.mesh.uv_faces[triangle]].mean(axis=0)
    height, width, _ = scan.texture.shape
    return tuple(int(c) for c in scan.texture[int((1 - v) * height), int(u * width)])


def test_each_material_has_its_own_picture(tmp_path):
    two_pages(tmp_path)
    scan = read_scan(tmp_path / "a.obj")
    assert [colour_at(scan, i) for i in range(4)] == [RED, RED, BLUE, BLUE]
    assert len(scan.mesh.vertices) == 6


def test_pages_stand_above_each_other(tmp_path):
    two_pages(tmp_path)
    paths = [tmp_path / "one.png", tmp_path / "two page.png"]
    assert page_sizes(paths).tolist() == [[8, 4], [4, 6]]
    assert read_pages(paths).shape == (10, 8, 3)


def test_coordinates_by_hand_repeats_and_none():
    sizes = np.array([[8, 4], [4, 6]])
    square = np.array([[[0.0, 0], [1, 0], [1, 1]]])
    np.testing.assert_allclose(on_pages(square, np.array([0]), sizes)[0], [[0, 0.6], [1, 0.6], [1, 1]])
    np.testing.assert_allclose(on_pages(square, np.array([1]), sizes)[0], [[0, 0], [0.5, 0], [0.5, 0.6]])
    np.testing.assert_allclose(on_pages(square + 3, np.array([1]), sizes), on_pages(square, np.array([1]), sizes))
    with_grey = np.array([[8, 4], [1, 1]])
    np.testing.assert_allclose(on_pages(square, np.array([1]), with_grey)[0], [[1 / 16, 0.1]] * 3)


@pytest.mark.parametrize("plain", ["newmtl b\nKd 1 1 1\n", ""])
def test_a_material_without_a_picture_beside_one_that_has_one_is_grey(tmp_path, plain):
    """The one picture would show everywhere."""
    two_pages(tmp_path)
    (tmp_path / "a.mtl").write_text(f"newmtl a\nmap_Kd one.png\n{plain}")
    scan = read_scan(tmp_path / "a.obj")
    assert [colour_at(scan, i) for i in range(4)] == [RED, RED, (128,) * 3, (128,) * 3]


def test_a_page_that_is_no_picture_is_one_line(tmp_path):
    two_pages(tmp_path)
    (tmp_path / "one.png").write_bytes(b"no picture")
    with pytest.raises(BadInput, match=r"one\.png: is no picture"):
        read_scan(tmp_path / "a.obj")
