"""Performances by suffix."""

import numpy as np
import pytest

from gltf_files import performance, refusal
from mien.errors import BadInput
from mien.io.performances import read_any_performance, write_any_performance


@pytest.mark.parametrize("name", ["a.glb", "a.USDA", "a.usdz"])
def test_out_and_in(tmp_path, name):
    play = performance()
    write_any_performance(tmp_path / name, play)
    np.testing.assert_allclose(read_any_performance(tmp_path / name).weights, play.weights, atol=1e-6)


def test_other_suffixes_are_told(tmp_path):
    with pytest.raises(BadInput, match="written as"):
        write_any_performance(tmp_path / "a.fbx", performance())
    (tmp_path / "a.fbx").touch()
    assert "no animated face" in refusal(read_any_performance, tmp_path / "a.fbx")
