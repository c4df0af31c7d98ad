"""Writing the RGB-D folder."""

from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.rgbd import read_rgbd, write_rgbd
from rgbd_takes import made


@pytest.fixture
def folder(tmp_path):
    write_rgbd(tmp_path / "take", made())
    return tmp_path / "take"


def test_depth_that_does_not_fit_sixteen_bits_is_refused(tmp_path):
    with pytest.raises(BadInput, match="lower depth_scale"):
        write_rgbd(tmp_path / "deep", made(), depth_scale=1e6)


def test_empty_take_is_refused(tmp_path):
    empty = replace(made(), count=0, frames=lambda: iter(()))
    write_rgbd(tmp_path / "empty", empty)
    with pytest.raises(BadInput, match="no images either"):
        read_rgbd(tmp_path / "empty")


def test_jpeg_colour_is_nearly_the_same_and_an_older_take_is_replaced(folder):
    write_rgbd(folder, made(2), color="jpg")
    take = read_rgbd(folder)
    assert len(take) == 2
    for found, expected in zip(take, made(2), strict=True):
        np.testing.assert_array_equal(found.depth, expected.depth)
        assert np.abs(found.color.astype(int) - expected.color).mean() < 6
