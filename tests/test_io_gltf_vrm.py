"""VRM's expressions by hand: older and newer files say the same."""

import json
import struct

import pytest

from mien.io.gltf.vrm import expression_pairs


def vrm(path, extensions):
    """A container with two morph targets whose names say nothing."""
    content = {
        "asset": {"version": "2.0"},
        "extensions": extensions,
        "nodes": [{"mesh": 0}],
        "meshes": [{"extras": {"targetNames": ["Mund", "Auge"]}, "primitives": [{"targets": [{}, {}]}]}],
    }
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), int.from_bytes(b"JSON", "little"))
    path.write_bytes(head + text)
    return path


def old(name, binds):
    return {"VRM": {"blendShapeMaster": {"blendShapeGroups": [{"name": name, "binds": binds}]}}}


def new(name, binds):
    return {"VRMC_vrm": {"expressions": {"custom": {name: {"morphTargetBinds": binds}}}}}


@pytest.mark.parametrize("make", [old, new])
def test_an_expression_names_the_target_that_it_moves(tmp_path, make):
    bind = {"mesh": 0, "node": 0, "index": 0}
    assert expression_pairs(vrm(tmp_path / "a.vrm", make("jawOpen", [bind])), ["jawOpen"]) == {"Mund": "jawOpen"}
    both = [bind, {**bind, "index": 1}]
    assert expression_pairs(vrm(tmp_path / "b.vrm", make("jawOpen", both)), ["jawOpen"]) == {}


def test_other_files_have_none(tmp_path):
    assert expression_pairs(vrm(tmp_path / "a.glb", {}), ["jawOpen"]) == {}
