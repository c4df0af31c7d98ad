import pytest

from mien.errors import BadInput
from mien.faces import load_face
from mien.io.gltf import write_performance, write_rig
from mien.mesh import Scan
from mien.rig import Performance, Rig
from mien.viewer.open_files import gather, open_face
from studio_things import nodding


def test_files_are_opened_by_what_is_in_them(tmp_path):
    write_performance(tmp_path / "perf.glb", nodding(3))
    write_rig(tmp_path / "rig.glb", load_face().rig)
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n")
    (tmp_path / "film.mp4").write_bytes(b"")
    assert isinstance(open_face(tmp_path / "perf.glb"), Performance)
    assert isinstance(open_face(tmp_path / "rig.glb"), Rig)
    shown, films = gather([tmp_path / "one.obj", tmp_path / "film.mp4"], "mm")
    assert isinstance(shown[0].thing, Scan)
    assert [film.name for film in films] == ["film.mp4"]


def test_what_cannot_be_shown_is_named(tmp_path):
    (tmp_path / "notes.txt").write_text("no")
    with pytest.raises(BadInput, match=r"notes\.txt: is nothing that can be shown"):
        gather([tmp_path / "notes.txt"])
    with pytest.raises(BadInput, match="no such file"):
        gather([tmp_path / "away.glb"])
