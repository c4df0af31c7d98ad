import numpy as np
import pytest

from mien.blendshapes.build.rig_files import write_textured_rig
from mien.clip import Markers
from mien.errors import BadInput
from mien.faces import load_face
from mien.io.gltf import write_performance, write_rig
from mien.io.markers import write_c3d
from mien.mesh import Scan
from mien.rig import Performance, Rig
from mien.transforms import Transform
from mien.viewer.open_files import gather, open_face, reopened
from studio_things import nodding, write_take
from test_blendshapes_build_masks import textured


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
    (tmp_path / "notes.doc").write_text("no")
    with pytest.raises(BadInput, match=r"notes\.doc: is nothing that can be shown"):
        gather([tmp_path / "notes.doc"])
    with pytest.raises(BadInput, match="no such file"):
        gather([tmp_path / "away.glb"])


def test_a_rig_brings_its_textures_and_a_performance_those_of_the_rig_that_is_named(tmp_path):
    rig = tmp_path / "me.glb"
    write_textured_rig(rig, textured())
    played = Performance(textured().rig, np.zeros((2, 2)), Transform.identity(2), 30.0, np.ones(2, bool))
    write_performance(tmp_path / "perf.glb", played)
    (alone,), _ = gather([tmp_path / "perf.glb"])
    (dressed, own), _ = gather([tmp_path / "perf.glb", rig], textured=rig)
    assert alone.textured is None
    assert dressed.textured.captures == own.textured.captures == ("smile", "blink")
    assert reopened(own).textured is not own.textured
    with pytest.raises(BadInput, match="no textures beside it"):
        gather([tmp_path / "perf.glb"], textured=tmp_path / "perf.glb")


def test_a_take_written_anew_is_read_again(tmp_path):
    write_performance(tmp_path / "perf.glb", nodding(5))
    write_take(tmp_path / "take.c3d", nodding(5))
    shown, _ = gather([tmp_path / "perf.glb", tmp_path / "take.c3d"])
    take = shown[1].thing
    write_c3d(tmp_path / "take.c3d", Markers(take.positions[:3], take.labels, take.rate))
    assert len(reopened(shown[1]).thing.positions) == 3
