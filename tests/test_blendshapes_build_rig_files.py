"""Textured rigs on disk."""

import json

import numpy as np
import pytest

from mien.blendshapes.build.rig_files import read_textured_rig, record_of, write_textured_rig
from mien.errors import BadInput
from test_blendshapes_build_masks import textured


def test_a_rig_comes_back_with_textures_masks_and_mixes(tmp_path):
    write_textured_rig(tmp_path / "me.glb", textured())
    again, first = read_textured_rig(tmp_path / "me.glb"), textured()
    assert again is not None
    assert again.captures == first.captures
    assert again.regions == first.regions
    np.testing.assert_array_equal(again.textures, first.textures)
    np.testing.assert_allclose(again.mixes, first.mixes)
    np.testing.assert_array_equal(again.texture(np.array([1.0, 0.5])), first.texture(np.array([1.0, 0.5])))
    assert (tmp_path / "me.textures" / "smile.png").is_file()


def test_a_rig_without_record_has_no_textures(tmp_path):
    assert read_textured_rig(tmp_path / "other.glb") is None


def test_damaged_records_are_told(tmp_path):
    write_textured_rig(tmp_path / "me.glb", textured())
    record = json.loads(record_of(tmp_path / "me.glb").read_text())
    record["captures"]["smile"]["texture"] = "gone.png"
    record_of(tmp_path / "me.glb").write_text(json.dumps(record))
    with pytest.raises(BadInput, match="no such file"):
        read_textured_rig(tmp_path / "me.glb")
    record_of(tmp_path / "me.glb").write_text("[]")
    with pytest.raises(BadInput, match="not a record"):
        read_textured_rig(tmp_path / "me.glb")
