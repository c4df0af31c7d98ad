"""Displacement maps: right in units, one a frame, beside the file or within it, and nothing for validators to say."""

import numpy as np
import pytest

from gltf_files import refusal
from mien.io import usd
from usd_files import complaints, performance


def maps(count):
    return np.random.default_rng(3).normal(0, 0.05, (count, 8, 8)).astype(np.float32)


@pytest.mark.parametrize(("suffix", "count"), [(".usdc", None), (".usdz", None), (".usda", 1)])
def test_maps_come_back(tmp_path, suffix, count):
    play, path = performance(), tmp_path / f"a{suffix}"
    heights = maps(count or len(play))
    usd.write_performance(path, play, iter(heights))
    assert complaints(path) == []
    np.testing.assert_allclose(list(usd.read_displacement(path)), heights, atol=1e-4)
    heard = []
    usd.read_performance(path, heard.append)
    assert "displacement maps are left out" in " ".join(heard)


def test_the_surface_is_moved_by_metres_at_each_time_code(tmp_path):
    from pxr import Usd, UsdShade

    usd.write_performance(tmp_path / "a.usdc", performance(), maps(3))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    material = UsdShade.Material(stage.GetPrimAtPath("/face/materials/skin"))
    shader = material.ComputeDisplacementSource()[0]
    assert shader.GetIdAttr().Get() == "UsdPreviewSurface"
    image = UsdShade.Shader(shader.GetInput("displacement").GetConnectedSources()[0][0].source.GetPrim())
    np.testing.assert_allclose(image.GetInput("scale").Get()[0], 1e-3)
    assert image.GetInput("file").Get(2).path == "./a.displacement/000002.exr"
    assert image.GetInput("file").GetAttr().GetTimeSamples() == [0, 1, 2]


def test_maps_that_are_lost_or_none_are_told(tmp_path):
    usd.write_performance(tmp_path / "a.usdc", performance())
    assert list(usd.read_displacement(tmp_path / "a.usdc")) == []
    assert not (tmp_path / "a.displacement").exists()
    usd.write_performance(tmp_path / "a.usdc", performance(), maps(2))
    (tmp_path / "a.displacement/000001.exr").write_bytes(b"no picture")
    assert "is no EXR" in refusal(lambda path: list(usd.read_displacement(path)), tmp_path / "a.usdc")
    (tmp_path / "a.displacement/000000.exr").unlink()
    assert "is missing" in refusal(lambda path: list(usd.read_displacement(path)), tmp_path / "a.usdc")
