"""Material libraries as exporters of many kinds write them."""

import pytest
from PIL import Image

from mien.io.meshes.materials import file_beside, pictures_of

PLAIN = "newmtl skin\nKd 1 1 1\nmap_Kd Face.png\nnewmtl eyes\nmap_Kd eyes.jpg\n"


@pytest.fixture
def folder(tmp_path):
    for name in ("Face.png", "eyes.jpg"):
        Image.new("RGB", (4, 4)).save(tmp_path / name)
    return tmp_path


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("map_Kd ", "map_Kd -s 1 1 1 -o 0 0 0 "),
        ("map_Kd ", "\tmap_Kd\t"),
        ("map_Kd", "MAP_KD"),
        ("map_Kd", "map_Ka"),
        ("newmtl", "NewMtl"),
        ("\n", "\r\n"),
        ("\n", "\r"),
        ("Face.png", '"face.PNG"'),
        ("Face.png", "C:\\Users\\me\\Face.png"),
        ("Face.png", "/home/me/textures/Face.png"),
        ("Kd 1 1 1", "map_Kd missing.png\nmap_Ka missing.png"),
    ],
)
def test_each_spelling_leads_to_the_pictures(folder, old, new):
    (folder / "head.mtl").write_bytes(PLAIN.replace(old, new).encode("utf-8-sig"))
    expected = {"skin": folder / "Face.png", "eyes": folder / "eyes.jpg"}
    assert pictures_of(folder / "head.obj", ["head.mtl"]) == expected


def test_libraries_on_one_line_with_blanks_elsewhere_and_of_the_meshs_own_name(folder):
    (folder / "a.mtl").write_text("newmtl skin\nmap_Kd Face.png\n")
    (folder / "two words.mtl").write_text("newmtl eyes\nmap_Kd eyes.jpg\n")
    assert set(pictures_of(folder / "head.obj", ["a.mtl none.mtl"])) == {"skin"}
    assert set(pictures_of(folder / "head.obj", ["two words.mtl"])) == {"eyes"}
    assert set(pictures_of(folder / "head.obj", ["C:\\jobs\\A.mtl"])) == {"skin"}
    assert set(pictures_of(folder / "a.obj", [])) == {"skin"}
    assert pictures_of(folder / "head.obj", ["none.mtl"]) == {}


def test_the_diffuse_picture_goes_before_the_ambient_one(folder):
    (folder / "a.mtl").write_text("newmtl skin\nmap_Ka eyes.jpg\nmap_Kd Face.png\nmap_Ka eyes.jpg\n")
    assert pictures_of(folder / "a.obj", ["a.mtl"]) == {"skin": folder / "Face.png"}


def test_what_is_not_there_is_none(folder):
    assert file_beside(folder, "nothing.png") is None
    assert file_beside(folder, ' "" ') is None
    assert file_beside(folder, "sub/eyes.jpg") == folder / "eyes.jpg"
