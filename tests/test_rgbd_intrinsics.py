"""Intrinsics of Open3D and of other programs."""

import json

import numpy as np
import pytest

from mien.errors import BadInput
from mien.rgbd import read_intrinsics, read_rgbd, write_intrinsics, write_rgbd
from rgbd_takes import CAMERA, made


@pytest.fixture
def folder(tmp_path):
    write_rgbd(tmp_path / "take", made())
    return tmp_path / "take"


def test_intrinsics_are_open3d_s_column_by_column(tmp_path):
    write_intrinsics(tmp_path / "c.json", CAMERA)
    matrix = np.reshape(json.loads((tmp_path / "c.json").read_text())["intrinsic_matrix"], (3, 3)).T
    np.testing.assert_array_equal(matrix, [[60, 0, 23.5], [0, 61, 15.5], [0, 0, 1]])
    assert read_intrinsics(tmp_path / "c.json") == CAMERA


def test_missing_and_broken_intrinsics(folder):
    (folder / "camera_intrinsic.json").write_text('{"width": 4}')
    with pytest.raises(BadInput, match="needs width, height and intrinsic_matrix"):
        read_rgbd(folder)
    (folder / "camera_intrinsic.json").unlink()
    with pytest.raises(BadInput, match="intrinsics are missing"):
        read_rgbd(folder)


@pytest.mark.parametrize(
    "content",
    [
        {"width": 48, "height": 32, "intrinsic_matrix": [60, 0, 23.5, 0, 61, 15.5, 0, 0, 1]},
        {"width": 48, "height": 32, "intrinsic_matrix": [[60, 0, 23.5], [0, 61, 15.5], [0, 0, 1]]},
        {"width": 48, "height": 32, "intrinsic_matrix": [[60, 0, 0], [0, 61, 0], [23.5, 15.5, 1]]},
        {"fx": 60, "fy": 61, "ppx": 23.5, "ppy": 15.5},
        {"camera_matrix": {"data": [60, 0, 23.5, 0, 61, 15.5, 0, 0, 1]}},
    ],
)
def test_intrinsics_in_other_forms(folder, content):
    (folder / "camera_intrinsic.json").write_text(json.dumps(content))
    assert read_rgbd(folder).camera == CAMERA
