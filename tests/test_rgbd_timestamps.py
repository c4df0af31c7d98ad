"""Clocks of recorders."""

import numpy as np
import pytest

from mien.rgbd import read_rgbd, write_rgbd
from rgbd_takes import made


@pytest.fixture
def folder(tmp_path):
    write_rgbd(tmp_path / "take", made())
    return tmp_path / "take"


@pytest.mark.parametrize(
    "text",
    [
        "timestamp_ms;frame\n1000;0\n1100;1\n1150;2\n1300;3\n",
        "0 5000000000\n1 5100000000\n2 5150000000\n3 5300000000\n",
        "filename,time\n000000.png,1.0\n000001.png,1.1\n000002.png,1.15\n000003.png,1.3\n",
    ],
)
def test_clocks_of_other_recorders(folder, text):
    (folder / "timestamps.csv").write_text(text)
    np.testing.assert_allclose([frame.time for frame in read_rgbd(folder)], [0, 0.1, 0.15, 0.3], atol=1e-6)
