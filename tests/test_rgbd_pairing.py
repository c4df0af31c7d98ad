"""Which colour image and which depth image are one frame."""

import pytest

from mien.errors import BadInput
from mien.rgbd import read_rgbd, write_rgbd
from rgbd_takes import made, same


@pytest.fixture
def folder(tmp_path):
    write_rgbd(tmp_path / "take", made())
    return tmp_path / "take"


def test_images_are_paired_by_number_not_by_order(folder):
    """Equal counts, but each stream lost another frame."""
    (folder / "color" / "000001.png").unlink()
    (folder / "depth" / "000002.png").unlink()
    (folder / "timestamps.csv").unlink()
    take = read_rgbd(folder)
    before = list(made())
    same(list(take), [before[0], before[3]])
    assert take.notes[0].endswith("1 colour and 1 depth images have no partner and are left out; 2 pairs remain")


def test_names_that_differ_are_paired_by_their_numbers(folder):
    for i, file in enumerate(sorted((folder / "depth").iterdir())):
        file.rename(folder / "depth" / f"depth_{i}.png")
    take = read_rgbd(folder)
    same(list(take), list(made()))
    assert take.notes == ()


def test_stamps_are_paired_with_the_nearest(folder):
    for kind, shift in (("color", 0.0), ("depth", 0.004)):
        for i, file in enumerate(sorted((folder / kind).iterdir())):
            file.rename(folder / kind / f"{1305031102.1 + i / 20 + shift:.6f}.png")
    (folder / "timestamps.csv").unlink()
    (folder / "depth" / "1305031102.154000.png").unlink()
    take = read_rgbd(folder)
    before = list(made())
    same(list(take), [before[0], before[2], before[3]], 1e-4)


def test_without_a_common_number_order_decides_and_a_line_says_so(folder):
    for i, file in enumerate(sorted((folder / "depth").iterdir())):
        file.rename(folder / "depth" / f"{i + 100}.png")
    assert "paired by order" in read_rgbd(folder).notes[0]
    (folder / "depth" / "100.png").unlink()
    with pytest.raises(BadInput, match="4 colour and 3 depth images"):
        read_rgbd(folder)


def test_a_number_that_all_names_share_says_nothing(folder):
    for kind, name in (("color", "cam1_{}_rgb8"), ("depth", "cam1_{}_mm16")):
        for i, file in enumerate(sorted((folder / kind).iterdir())):
            file.rename(folder / kind / f"{name.format(i)}.png")
    (folder / "color" / "cam1_1_rgb8.png").unlink()
    (folder / "depth" / "cam1_2_mm16.png").unlink()
    (folder / "timestamps.csv").unlink()
    before = list(made())
    same(list(read_rgbd(folder)), [before[0], before[3]])
