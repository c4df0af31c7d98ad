"""RGB-D folders: written and read back, scaled, cut off, of colour alone."""

import numpy as np
import pytest
from PIL import Image

from mien.camera import Camera
from mien.errors import BadInput
from mien.rgbd import read_rgbd, write_rgbd
from rgbd_takes import CAMERA, made, same


@pytest.fixture
def folder(tmp_path):
    write_rgbd(tmp_path / "take", made())
    return tmp_path / "take"


def test_folder_comes_back_as_written_and_can_be_walked_twice(folder):
    take = read_rgbd(folder)
    assert (take.camera, take.rate, len(take), take.has_depth) == (CAMERA, 20.0, 4, True)
    same(take, made())
    same(take, made())


def test_depth_scale_is_units_a_metre(tmp_path):
    write_rgbd(tmp_path / "fine", made(), depth_scale=5000.0)
    same(read_rgbd(tmp_path / "fine"), made(), tolerance=0.11)
    wrong = next(iter(read_rgbd(tmp_path / "fine", depth_scale=1000.0))).depth
    np.testing.assert_allclose(wrong, 5 * next(iter(made())).depth, atol=0.6)


def test_sizes_of_one_view_are_brought_together_and_others_refused(folder):
    before, first = read_rgbd(folder), next(iter(read_rgbd(folder)))
    for file in (folder / "color").iterdir():
        Image.open(file).resize((96, 64)).save(file)
    take = read_rgbd(folder)
    assert "colour 96 x 64, depth 48 x 32" in take.notes[0]
    assert take.camera == before.camera.scaled(2)
    np.testing.assert_array_equal(next(iter(take)).depth[::2, ::2], first.depth)
    for file in (folder / "color").iterdir():
        Image.open(file).resize((96, 96)).save(file)
    with pytest.raises(BadInput, match="colour 96 x 96, depth 48 x 32"):
        read_rgbd(folder)


def test_a_take_cut_off_in_a_frame_gives_the_frames_before(folder):
    file = folder / "depth" / "000002.png"
    file.write_bytes(file.read_bytes()[:-400])
    frames, seen = iter(read_rgbd(folder)), []
    seen += [next(frames), next(frames)]
    with pytest.raises(BadInput, match=r"000002.png: cannot be read to its end"):
        seen.extend(frames)
    same(seen, list(made())[:2])


def test_bad_depth_images_settings_and_clock(folder):
    (folder / "timestamps.csv").write_text("frame,seconds\n0,0\n1,0.2\n2,0.1\n3,0.4\n")
    with pytest.raises(BadInput, match="seconds must grow; they do not after frame 1"):
        read_rgbd(folder)
    (folder / "timestamps.csv").write_text("a,b\n")
    with pytest.raises(BadInput, match="needs columns frame,seconds"):
        read_rgbd(folder)
    (folder / "timestamps.csv").unlink()
    (folder / "take.json").write_text('{"fps": 0}')
    with pytest.raises(BadInput, match="fps must be above 0"):
        read_rgbd(folder)
    (folder / "take.json").unlink()
    Image.fromarray(np.zeros((32, 48), np.uint8)).save(folder / "depth" / "000000.png")
    with pytest.raises(BadInput, match="must be a 16-bit grey PNG"):
        list(read_rgbd(folder))


def test_what_is_no_take_is_refused(tmp_path):
    (tmp_path / "a.txt").write_text("x")
    with pytest.raises(BadInput, match="not a take; give"):
        read_rgbd(tmp_path / "a.txt")
    with pytest.raises(BadInput, match="no images either"):
        read_rgbd(tmp_path)
    with pytest.raises(BadInput, match="no such file"):
        read_rgbd(tmp_path / "nothing")


def test_images_alone_are_a_take_without_depth(folder):
    for file in (folder / "depth").iterdir():
        file.unlink()
    (folder / "depth").rmdir()
    take = read_rgbd(folder, rate=10.0)
    assert (take.has_depth, take.rate, take.camera, take.guessed_camera) == (False, 10, CAMERA, False)
    assert all(frame.depth is None for frame in take)
    loose = read_rgbd(folder / "color", focal=50.0)
    assert loose.camera == Camera(50.0, 50.0, 23.5, 15.5, 48, 32)


def test_a_folder_says_with_which_scale_it_was_read(folder):
    assert read_rgbd(folder).depth_scale == 1000
    assert read_rgbd(folder, depth_scale=250.0).depth_scale == 250


def test_parts_under_other_names_and_capitals(folder):
    before = list(read_rgbd(folder))
    for ours, theirs in (("color", "RGB"), ("depth", "Depth"), ("camera_intrinsic.json", "intrinsics.json")):
        (folder / ours).rename(folder / theirs)
    same(list(read_rgbd(folder)), before)
