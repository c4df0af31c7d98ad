"""`mien FILE`."""

import pytest

from gltf_files import performance, rig
from marker_files import take, wide_csv
from mien.cli.about import about
from mien.errors import BadInput
from mien.io.gltf import write_performance, write_rig
from mien.io.livelink import write_live_link
from mien.io.markers import write_c3d


def test_what_it_is_and_what_can_be_done(tmp_path):
    path = tmp_path / "a.glb"
    write_performance(path, performance(3))
    first, second, *commands = about(path)
    assert first == f"{path}: an animated face"
    assert "3 frames at 60 a second" in second
    assert any(f"mien view {path} " in line for line in commands)
    assert not any("FILE" in line for line in commands)


def test_a_file_is_not_converted_to_what_it_is(tmp_path):
    write_c3d(tmp_path / "a.c3d", take())
    wide_csv(tmp_path / "a.csv", take().positions)
    for name, told in (("a.c3d", False), ("a.csv", True)):
        path = tmp_path / name
        assert any(f"mien convert {path} -o take.c3d" in line for line in about(path)) == told


def test_other_kinds_say_what_is_in_them(tmp_path):
    write_rig(tmp_path / "rig.glb", rig())
    assert "Rig(4 shapes" in about(tmp_path / "rig.glb")[1]
    write_live_link(tmp_path / "a.csv", performance(5))
    assert "5 frames" in about(tmp_path / "a.csv")[1]


def test_what_is_of_no_kind_is_told(tmp_path):
    (tmp_path / "a.xyz").touch()
    with pytest.raises(BadInput, match="of no kind that mien knows"):
        about(tmp_path / "a.xyz")
