"""Morph targets in glTF."""

from gltf_files import rig
from mien.io.gltf import write_rig
from mien.io.gltf.glb import open_glb


def test_local_shapes_are_stored_sparsely(tmp_path):
    write_rig(tmp_path / "rig.glb", rig())
    glb = open_glb(tmp_path / "rig.glb")
    targets = [t["POSITION"] for t in glb.json["meshes"][0]["primitives"][0]["targets"]]
    assert [("sparse" in glb.json["accessors"][i]) for i in targets] == [True, True, False, False]
