"""`mien track` on takes that break off, or do not fit."""

import pytest

import tracking_stage as stage
from mien.io.gltf import read_performance, write_rig
from mien.rig import Rig
from rgbd_study import track_shell


@pytest.fixture
def shell(tmp_path, monkeypatch, capsys):
    return track_shell(tmp_path, monkeypatch, capsys)


def test_a_take_that_breaks_off_keeps_what_was_tracked(shell):
    folder, _, call = shell
    broken = folder / "take" / "depth" / "000009.png"
    broken.write_bytes(broken.read_bytes()[:-3000])
    assert "000009.png: cannot be read to its end" in (line := call())
    assert "the 9 frames before are in" in line
    assert len(read_performance(folder / "perf.glb")) == 9
    assert "The take ended early" in (folder / "perf.html").read_text()
    assert (folder / "perf.png").is_file()


def test_the_scale_that_would_fit_is_named(shell):
    folder, _, call = shell
    (folder / "take" / "take.json").write_text('{"depth_scale": 150, "fps": 30}')
    line = call()
    assert "with 150 units of depth a metre the face is" in line
    assert "--depth-scale 1000 would make it 1" in line
    assert not (folder / "perf.glb").exists()


def test_a_take_without_a_face_is_said_so(shell):
    folder, told, call = shell
    told.update(dict.fromkeys(told))
    assert "no face in any of its 12 frames" in call()
    assert not (folder / "perf.glb").exists()


def test_a_rig_without_the_shapes_is_named(shell):
    folder, _, call = shell
    rig = stage.person()
    write_rig(folder / "odd.glb", Rig(rig.neutral, rig.deltas[:2], ("Key_1", "Key_2")))
    assert "odd.glb has none of the ARKit shapes (it has Key_1, Key_2)" in call(rig="odd.glb")


def test_a_take_without_intrinsics_is_said_so(shell):
    folder, _, call = shell
    (folder / "take" / "camera_intrinsic.json").unlink()
    assert "the camera's intrinsics are missing" in call()
