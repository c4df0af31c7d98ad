"""Morph targets in glTF."""

from pathlib import Path

import pytest

from gltf_files import rig
from mien.errors import BadInput
from mien.io.gltf import write_rig
from mien.io.gltf.glb import Glb, open_glb
from mien.io.gltf.shapes import shape_names


def test_local_shapes_are_stored_sparsely(tmp_path):
    write_rig(tmp_path / "rig.glb", rig())
    glb = open_glb(tmp_path / "rig.glb")
    targets = [t["POSITION"] for t in glb.json["meshes"][0]["primitives"][0]["targets"]]
    assert [("sparse" in glb.json["accessors"][i]) for i in targets] == [True, True, False, False]


def test_names_that_are_no_text_and_no_list():
    """Names are asked for their endings later on."""
    glb = Glb(Path("a.glb"), {}, b"")
    parts = [{"targets": [{}, {}]}]
    assert shape_names(glb, {"primitives": parts, "extras": {"targetNames": ["jawOpen", 7]}}) == ("jawOpen", "7")
    with pytest.raises(BadInput, match="no list"):
        shape_names(glb, {"primitives": parts, "extras": {"targetNames": 7}})
