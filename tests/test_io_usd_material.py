"""Colours: a texture, vertex colours, or none."""

from dataclasses import replace

import numpy as np

from mien.io import usd
from usd_files import complaints, rig


def test_vertex_colours_come_back(tmp_path):
    plain = rig()
    colors = np.random.default_rng(1).random(plain.neutral.vertices.shape)
    colored = replace(plain, neutral=replace(plain.neutral, colors=colors), texture=None)
    usd.write_rig(tmp_path / "a.usda", colored)
    np.testing.assert_allclose(usd.read_rig(tmp_path / "a.usda").neutral.colors, colors, atol=1e-6)
    assert complaints(tmp_path / "a.usda") == []


def test_a_texture_that_is_lost_is_none(tmp_path):
    usd.write_rig(tmp_path / "a.usda", rig())
    (tmp_path / "a.base_color.png").unlink()
    assert usd.read_rig(tmp_path / "a.usda").texture is None
    (tmp_path / "a.base_color.png").write_bytes(b"no picture")
    assert usd.read_rig(tmp_path / "a.usda").texture is None


def test_a_rig_without_colours_is_skin(tmp_path):
    usd.write_rig(tmp_path / "a.usda", replace(rig(), texture=None))
    assert "diffuseColor = (0.6, 0.45, 0.38)" in (tmp_path / "a.usda").read_text()
    assert complaints(tmp_path / "a.usda") == []
