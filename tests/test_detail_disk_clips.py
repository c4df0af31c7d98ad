import numpy as np
import pytest

from detail_patch import write_clips
from mien.detail.disk.clips import read_training, shown_vertices
from mien.errors import BadInput
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
