import shutil

import numpy as np
import pytest
from PIL import Image

import light_scene
from mien.errors import BadInput
from mien.light.disk.light_take import pictures_of, read_grey, read_light_take
from mien.light.light_rig import write_rig
from mien.light.patterns import paper_set, write_patterns


@pytest.fixture
def folder(tmp_path):
    """Two captures of two cameras, pictures of noise."""
    rng = np.random.default_rng(0)
    write_patterns(tmp_path / "patterns.json", paper_set(256, 256))
    write_rig(tmp_path / "calibration.json", light_scene.rig())
    for name in ("left", "right"):
        (tmp_path / name).mkdir()
        for number in range(24):
            save(tmp_path / name / f"{number}.png", rng.integers(5000, 50000, size=(200, 160)))
    return tmp_path


def save(path, values):
    Image.fromarray(values.astype(np.uint16)).save(path)


def test_captures_are_read_in_the_order_of_their_numbers(folder):
    take = read_light_take(folder)
    assert len(take) == 2
    assert [path.stem for path in take.pictures["left"][:3]] == ["0", "1", "2"]
    captures = list(take)
    assert captures[1]["right"].shape == (12, 200, 160)
    np.testing.assert_allclose(captures[1]["right"][0], read_grey(folder / "right" / "12.png"))


def test_grey_of_any_picture(tmp_path):
    Image.fromarray(np.full((4, 5, 3), 128, np.uint8)).save(tmp_path / "a.png")
    assert read_grey(tmp_path / "a.png")[0, 0] == pytest.approx(128 / 255)
    assert read_grey(tmp_path / "a.png", 2.2)[0, 0] == pytest.approx(0.2158, abs=1e-3)
    assert read_grey(tmp_path / "a.png", 2.0)[0, 0] == pytest.approx((128 / 255) ** 2)
    (tmp_path / "b.png").write_bytes(b"no picture")
    with pytest.raises(BadInput, match=r"b\.png"):
        read_grey(tmp_path / "b.png")
    assert [path.name for path in pictures_of(tmp_path)] == ["a.png", "b.png"]


def test_each_fault_is_one_clear_line(folder):
    (folder / "left" / "7.png").unlink()
    with pytest.raises(BadInput, match="23 pictures, 12 slots a capture: number 7 is missing"):
        read_light_take(folder)
    shutil.copy(folder / "left" / "6.png", folder / "left" / "7.png")
    with pytest.raises(BadInput, match="the same picture as 6"):
        read_light_take(folder).capture(0)
    shutil.copy(folder / "left" / "2.png", folder / "left" / "7.png")
    with pytest.raises(BadInput, match="the same picture as 2"):
        read_light_take(folder).capture(0)
    save(folder / "left" / "7.png", np.zeros((100, 80)))
    with pytest.raises(BadInput, match="80 x 100"):
        read_light_take(folder).capture(0)
    rng = np.random.default_rng(1)
    save(folder / "left" / "7.png", rng.integers(0, 300, size=(200, 160)))
    with pytest.raises(BadInput, match="black, where constant light"):
        read_light_take(folder).capture(0)
    save(folder / "left" / "7.png", rng.integers(65200, 65535, size=(200, 160)))
    with pytest.raises(BadInput, match="saturated"):
        read_light_take(folder).capture(0)
    face = np.zeros((200, 160))
    face[60:140, 60:100] = 65535
    save(folder / "left" / "7.png", face + rng.integers(0, 300, size=face.shape) - 300 * (face > 0))
    with pytest.raises(BadInput, match="saturated over half of what is lit"):
        read_light_take(folder).capture(0)
    (folder / "other").mkdir()
    shutil.copy(folder / "left" / "2.png", folder / "other" / "2.png")
    with pytest.raises(BadInput, match="other: pictures of no camera"):
        read_light_take(folder)
    shutil.rmtree(folder / "other")
    for number in range(12, 24):
        (folder / "right" / f"{number}.png").unlink()
    with pytest.raises(BadInput, match="different numbers"):
        read_light_take(folder)
    shutil.rmtree(folder / "right")
    shutil.rmtree(folder / "left")
    with pytest.raises(BadInput, match="no folder of any camera"):
        read_light_take(folder)
    with pytest.raises(BadInput, match="expected a folder"):
        read_light_take(folder / "patterns.json")
    (folder / "patterns.json").unlink()
    with pytest.raises(BadInput, match=r"no patterns\.json in it or beside it; .* writes one"):
        read_light_take(folder)


@pytest.mark.parametrize(("level", "line"), [(0, "black, where"), (65535, "saturated over half")])
def test_pictures_that_are_all_black_or_all_white_are_told_so_though_they_are_alike(folder, level, line):
    for number in range(12):
        save(folder / "left" / f"{number}.png", np.full((200, 160), level))
    with pytest.raises(BadInput, match=line):
        read_light_take(folder).capture(0)
