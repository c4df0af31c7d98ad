from dataclasses import replace

import numpy as np
import pytest

from detail_patch import training, write_clips
from mien.clip import Markers
from mien.detail.disk.clips import read_training, shown_vertices
from mien.errors import BadInput
from mien.io.markers.c3d import write_c3d
from mien.io.meshes.ply import read_ply, write_ply
from mien.mesh import Mesh


def test_clips_come_back(tmp_path):
    whole = write_clips(tmp_path)
    back, notes = read_training(tmp_path)
    assert notes == []
    assert [clip.name for clip in back.clips] == ["shear", "squeeze"]
    np.testing.assert_allclose(back.clips[1].markers, whole.clips[0].markers, atol=1e-3)
    for a, b in zip(back.clips[1].frames(), whole.clips[0].frames(), strict=True):
        np.testing.assert_allclose(a.vertices, b.vertices, atol=1e-3)
    np.testing.assert_allclose(back.markers, whole.markers, atol=1e-3)


def test_one_bad_clip_is_named_and_left_out(tmp_path):
    write_clips(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "shear" / "frame_000099.ply").write_bytes((tmp_path / "shear" / "frame_000001.ply").read_bytes())
    back, notes = read_training(tmp_path)
    assert [clip.name for clip in back.clips] == ["squeeze"]
    assert any("empty: 0 marker files" in note for note in notes)
    assert any("frame 99, and the take has 8" in note for note in notes)


def test_frames_without_a_mesh_are_dropped(tmp_path):
    write_clips(tmp_path)
    for number in (2, 5):
        (tmp_path / "squeeze" / f"frame_{number:06d}.ply").unlink()
    back, _ = read_training(tmp_path)
    assert len(back.clips[1].markers) == 6
    assert len(list(back.clips[1].frames())) == 6


def test_nothing_to_read_is_one_line(tmp_path):
    with pytest.raises(BadInput, match="no clips in it"):
        read_training(tmp_path)
    with pytest.raises(BadInput, match="no such file"):
        read_training(tmp_path / "nowhere")
    write_clips(tmp_path)
    for mesh in (tmp_path / "squeeze").glob("*.ply"):
        mesh.unlink()
    (tmp_path / "shear" / "markers.c3d").unlink()
    with pytest.raises(BadInput, match=r"no clips.*0 marker files"):
        read_training(tmp_path)


def test_a_vertex_without_a_triangle_is_not_seen():
    mesh = Mesh(np.eye(4, 3), np.array([[0, 1, 2]]))
    assert np.isnan(shown_vertices(mesh)).any(axis=1).tolist() == [False, False, False, True]


def cut(clip, first, last):
    """The clip's frames from `first` to before `last`."""
    markers = clip.markers[first:last]
    return replace(clip, markers=markers, frames=lambda: iter(list(clip.frames())[first:last]))


def named(clip, name):
    return replace(clip, name=name)


def test_a_clip_of_one_frame_is_named_and_left_out(tmp_path):
    squeeze, shear = training().clips
    write_clips(tmp_path, (squeeze, named(cut(shear, 7, 8), "alone")))
    back, notes = read_training(tmp_path)
    assert [clip.name for clip in back.clips] == ["squeeze"]
    assert [note for note in notes if "alone: a clip of one frame" in note] == notes


def test_one_frame_is_enough_for_the_neutral(tmp_path):
    squeeze, shear = training().clips
    write_clips(tmp_path, (squeeze, named(cut(shear, 0, 1), "neutral")))
    back, notes = read_training(tmp_path)
    assert [clip.name for clip in back.clips] == ["squeeze"]
    assert notes == []


def test_a_clip_of_other_markers_does_not_take_them_from_the_rest(tmp_path):
    squeeze, shear = training().clips
    write_clips(tmp_path, (squeeze, shear, named(shear, "strange")))
    labels = tuple(f"M{i}" if i < 5 else f"X{i}" for i in range(25))
    write_c3d(tmp_path / "strange" / "markers.c3d", Markers(shear.markers, labels, 30.0))
    back, notes = read_training(tmp_path)
    assert len(back.labels) == 25
    assert [clip.name for clip in back.clips] == ["shear", "squeeze"]
    assert len(notes) == 1
    assert "strange: 5 of the 25 markers" in notes[0]


def test_a_clip_of_another_topology_is_named_and_left_out(tmp_path):
    squeeze, shear = training().clips
    write_clips(tmp_path, (squeeze, named(shear, "cut")))
    first = tmp_path / "cut" / "frame_000000.ply"
    whole, _ = read_ply(first)
    write_ply(first, Mesh(whole.vertices[:-1], whole.faces[(whole.faces < 1088).all(axis=1)]))
    (tmp_path / "neutral").mkdir()
    for name in ("markers.c3d", "frame_000000.ply"):
        (tmp_path / "neutral" / name).write_bytes((tmp_path / "squeeze" / name).read_bytes())
    back, notes = read_training(tmp_path)
    assert [clip.name for clip in back.clips] == ["squeeze"]
    assert any("frame_000000.ply: 1,088 vertices where the neutral has 1,089" in note for note in notes)


def test_a_clip_that_starts_in_an_expression_is_not_the_neutral(tmp_path):
    """The first by name: its start was the neutral of all others."""
    squeeze, shear = training().clips
    write_clips(tmp_path, (named(cut(squeeze, 5, 8), "a_late"), squeeze, shear))
    back, notes = read_training(tmp_path)
    np.testing.assert_allclose(back.markers, training().markers, atol=1e-3)
    assert len(back.clips) == 3
    assert len(notes) == 1
    assert "a_late: no neutral frame" in notes[0]


def test_colours_are_linear(tmp_path):
    whole = write_clips(tmp_path, training().clips[:1])
    for path in (tmp_path / "squeeze").glob("*.ply"):
        mesh, _ = read_ply(path)
        write_ply(path, replace(mesh, colors=np.full((len(whole.mesh.vertices), 3), 128 / 255)))
    back, _ = read_training(tmp_path)
    frame = next(back.clips[0].frames())
    np.testing.assert_allclose(frame.colors, 0.2158605, atol=1e-6)


def test_a_damaged_mesh_within_a_clip_shows_nothing_and_is_named(tmp_path):
    write_clips(tmp_path)
    (tmp_path / "shear" / "frame_000002.ply").write_text("x")
    clips, notes = read_training(tmp_path)
    shear = next(clip for clip in clips.clips if clip.name == "shear")
    for _ in range(2):
        shown = [np.isfinite(frame.vertices).all() for frame in shear.frames()]
    assert shown == [True, True, False, True, True, True, True, True]
    assert sum("frame_000002.ply" in note for note in notes) == 1
