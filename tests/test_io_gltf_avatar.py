"""Performances on avatars of other programs: all that the file held stays, the head turns in its place."""

import base64
import json
import struct

import numpy as np
import pytest

from command import mien
from gltf_validator import assert_valid_gltf
from mien.cli.play import play_on
from mien.errors import BadInput
from mien.io.gltf import read_performance, read_rig
from mien.io.gltf.glb import GlbBuilder, open_glb
from mien.io.gltf.scene import global_matrix
from mien.io.gltf.vrm import expression_pairs
from mien.mesh import Mesh
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector

NAMES = ("eyeBlinkLeft", "eyeBlinkRight", "jawOpen", "tongueOut")
NOD = rotation_from_vector(np.linspace(0, 0.5, 5)[:, None] * [1.0, 0, 0])


def nod(*extra: str) -> Performance:
    """Three shapes and a nod in face space."""
    names = (*NAMES[:3], *extra)
    rig = Rig(Mesh(np.eye(3), np.array([[0, 1, 2]])), np.zeros((len(names), 3, 3)), names)
    weights = np.linspace(0, 1, 5)[:, None] * np.ones(len(names)) * 0.8
    return Performance(rig, weights, Transform(NOD, np.zeros((5, 3))), 30.0, np.ones(5, bool))


def face(build: GlbBuilder, name: str, names, height: float = 1.6, extras: bool = True) -> int:
    """A patch of a face at that height, metres; each shape moves a corner of it."""
    x, y = np.meshgrid(np.linspace(-0.07, 0.07, 5), np.linspace(-0.1, 0.1, 5))
    points = np.stack([x.ravel(), y.ravel() + height, 0.1 - 4 * x.ravel() ** 2], 1).astype(np.float32)
    i = (np.arange(4)[:, None] * 5 + np.arange(4)).ravel()
    faces = np.concatenate([np.stack([i, i + 1, i + 5], 1), np.stack([i + 1, i + 6, i + 5], 1)])
    spots = [(0.03, 0.03), (-0.03, 0.03), (0, -0.06), (0, -0.05)]
    targets = []
    for (cx, cy), _ in zip(spots, names, strict=False):
        near = np.exp(-((x.ravel() - cx) ** 2 + (y.ravel() - cy) ** 2) / 0.02**2)
        shift = (near[:, None] * [0, -0.005, 0]).astype(np.float32)
        targets.append({"POSITION": build.accessor(shift, bounds=True)})
    part = {"attributes": {"POSITION": build.accessor(points, bounds=True)}, "targets": targets,
            "indices": build.accessor(faces.astype(np.uint16).ravel())}  # fmt: skip
    mesh = {"name": name, "primitives": [part], "extras": {"mine": 1}}
    mesh["extras"] |= {"targetNames": list(names)} if extras else {}
    part |= {} if extras else {"extras": {"targetNames": list(names)}}
    return build.add("meshes", mesh)


def avatar(path, spell=str, **scene):
    """Head, teeth and feet as meshes of their own, a material, an animation and an extension of somebody."""
    build = GlbBuilder()
    build.json["asset"]["generator"] = "other"
    build.add("materials", {"name": "skin", "extras": {"shader": "x"}})
    head = face(build, "Head", [spell(name) for name in NAMES])
    teeth = face(build, "Teeth", [spell("jawOpen")], extras=False)
    feet = face(build, "Feet", ["wiggle"], height=0.1)
    for mesh, name in ((head, "Head"), (teeth, "Teeth"), (feet, "Feet")):
        build.add("nodes", {"mesh": mesh, "name": name, "extras": {"of": name}})
    clock, turn = (
        build.accessor(np.zeros(1, np.float32), bounds=True),
        build.accessor(np.array([[0, 0, 0, 1]], np.float32)),
    )
    build.add("animations", {"name": "idle", "samplers": [{"input": clock, "output": turn}],
                             "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}]})  # fmt: skip
    build.json |= {"scenes": [{"nodes": [0, 1, 2]}], "scene": 0, "extras": {"author": "me"}, **scene}
    build.save(path)
    return path


def place(glb, node: int, animation: int, frame: int) -> np.ndarray:
    """Where a node's own origin and axes are in a frame: by glTF's rules alone."""
    changed = json.loads(json.dumps(glb.json))
    for channel in glb.json["animations"][animation]["channels"]:
        target = channel["target"]
        if target["path"] != "weights":
            values = glb.accessor(glb.json["animations"][animation]["samplers"][channel["sampler"]]["output"])
            changed["nodes"][target["node"]][target["path"]] = values[frame].tolist()
    return global_matrix(type(glb)(glb.path, changed, glb.blob), node)


def test_everything_stays_and_every_mesh_with_the_names_moves(tmp_path):
    source = avatar(tmp_path / "a.glb")
    play_on(nod(), source, tmp_path / "o.glb", {})
    before, after = open_glb(source).json, open_glb(tmp_path / "o.glb").json
    assert after["meshes"] == before["meshes"]
    assert after["materials"] == before["materials"]
    assert after["extras"] == {"author": "me"}
    assert [a["name"] for a in after["animations"]] == ["performance", "idle"]
    assert after["nodes"][1:3] == before["nodes"][1:3]
    channels = after["animations"][0]["channels"]
    assert {c["target"]["node"] for c in channels if c["target"]["path"] == "weights"} == {0, 1}
    assert_valid_gltf(tmp_path / "o.glb")
    back = read_performance(tmp_path / "o.glb")
    np.testing.assert_allclose(back.weights[:, :3], nod().weights, atol=1e-6)
    assert back.rate == 30


def test_the_head_and_its_teeth_turn_in_place_and_the_feet_stand(tmp_path):
    play_on(nod(), avatar(tmp_path / "a.glb"), tmp_path / "o.glb", {})
    glb = open_glb(tmp_path / "o.glb")
    centre = np.array([0, 1.6, 0.05, 1])
    for node in (0, 1):
        moved = place(glb, node, 0, 4)
        np.testing.assert_allclose(moved[:3, :3], NOD[4], atol=1e-6)
        assert np.linalg.norm((moved @ centre)[:3] - centre[:3]) < 0.05
    np.testing.assert_array_equal(place(glb, 2, 0, 4), np.eye(4))


@pytest.mark.parametrize("bone", ["mixamorig:Head", "Kopf"])
def test_a_bone_turns_the_head_instead(tmp_path, bone):
    """The bone's parent is turned; the face is skinned to it, its jaw to one below, a little of it to the spine."""
    half = np.sqrt(0.5)

    def skinned(path):
        avatar(path)
        glb = open_glb(path)
        build = GlbBuilder(glb.json, bytearray(glb.blob))
        build.add("nodes", {"name": "Spine", "rotation": [half, 0, 0, half], "children": [4], "scale": [0.01] * 3})
        build.add("nodes", {"name": bone, "translation": [0, 0, -150], "children": [5]})
        build.add("nodes", {"name": "Kiefer"})
        placed = [global_matrix(type(glb)(glb.path, build.json, b""), n) for n in (3, 4, 5)]
        binds = np.stack([np.linalg.inv(each).T.ravel() for each in placed]).astype(np.float32)
        build.add("skins", {"joints": [3, 4, 5], "inverseBindMatrices": build.accessor(binds)})
        build.json["accessors"][-1]["type"] = "MAT4"
        weights = np.tile(np.array([[0.05, 0.6, 0.35, 0]], np.float32), (25, 1))
        part = build.json["meshes"][0]["primitives"][0]
        joints = np.tile(np.array([[0, 1, 2, 0]], np.uint16), (25, 1))
        part["attributes"] |= {"JOINTS_0": build.accessor(joints), "WEIGHTS_0": build.accessor(weights)}
        build.json["nodes"][0]["skin"] = 0
        build.json["scenes"][0]["nodes"] = [0, 1, 2, 3]
        build.save(path)
        return path

    source = skinned(tmp_path / "a.glb")
    assert abs(read_rig(source).neutral.vertices[:, 1].mean() - 1600) < 1
    play_on(nod(), source, tmp_path / "o.glb", {})
    glb = open_glb(tmp_path / "o.glb")
    joint = place(glb, 4, 0, 4) @ np.linalg.inv(place(glb, 4, 0, 0))
    np.testing.assert_allclose(joint[:3, :3], NOD[4], atol=1e-6)
    np.testing.assert_allclose(place(glb, 4, 0, 4)[:3, 3], [0, 1.5, 0], atol=1e-6)
    np.testing.assert_allclose(read_performance(tmp_path / "o.glb").T_world_face.rotation, NOD, atol=1e-6)


def test_other_spellings_are_told_and_a_map_names_the_rest(tmp_path, capsys):
    spelled = {"jawOpen": "Mund", "tongueOut": "Zunge"}
    source = avatar(tmp_path / "a.glb", lambda name: spelled.get(name, f"blendShape1.{name}"))
    (tmp_path / "map.csv").write_text("Mund,jawOpen\n")
    result, _ = play_on(nod(), source, tmp_path / "o.glb", {"Mund": "jawOpen"})
    assert result.moved == NAMES[:3]
    assert "2 shape names matched loosely: blendShape1.eyeBlinkLeft = eyeBlinkLeft" in capsys.readouterr().err


def test_correctives_come_along_as_shapes_within_bounds(tmp_path):
    source = avatar(tmp_path / "a.glb")
    target = read_rig(source)
    names = (*NAMES[:3], "corrective_01")
    deltas = np.concatenate([target.deltas[:3], np.ones((1, len(target.neutral.vertices), 3))])
    weights = np.array([[0.1, 0, 0, -3.0], [0.2, 0, 0, 5.0]])
    take = Performance(Rig(target.neutral, deltas, names), weights, Transform.identity(2), 30.0, np.ones(2, bool))
    play_on(take, source, tmp_path / "o.glb", {})
    glb = open_glb(tmp_path / "o.glb")
    assert glb.json["meshes"][0]["extras"]["targetNames"][-2:] == ["corrective_01", "corrective_01_neg"]
    back = read_performance(tmp_path / "o.glb")
    shown = back.rig.vertices(back.weights)
    np.testing.assert_allclose(shown, take.rig.vertices(weights), atol=2e-3)
    assert_valid_gltf(tmp_path / "o.glb")


def test_gltf_with_buffers_beside_it_or_inside(tmp_path):
    glb = open_glb(avatar(tmp_path / "a.glb"))
    (tmp_path / "my data.bin").write_bytes(glb.blob)
    outside = glb.json | {"buffers": [{"uri": "my%20data.bin", "byteLength": len(glb.blob)}]}
    (tmp_path / "b.gltf").write_text(json.dumps(outside))
    inside = "data:application/octet-stream;base64," + base64.b64encode(glb.blob).decode()
    (tmp_path / "c.gltf").write_text(json.dumps(glb.json | {"buffers": [{"uri": inside, "byteLength": len(glb.blob)}]}))
    for name in ("b.gltf", "c.gltf"):
        np.testing.assert_array_equal(read_rig(tmp_path / name).deltas, read_rig(tmp_path / "a.glb").deltas)
    (tmp_path / "my data.bin").unlink()
    with pytest.raises(BadInput, match="not beside it"):
        read_rig(tmp_path / "b.gltf")


def test_compressed_files_are_refused_with_the_command_that_undoes_it(tmp_path):
    avatar(tmp_path / "a.glb", extensionsUsed=["EXT_meshopt_compression"])
    with pytest.raises(BadInput, match=r"gltf-transform/cli copy a\.glb a-plain\.glb"):
        read_rig(tmp_path / "a.glb")


def test_vrm_expressions_name_targets_that_say_nothing(tmp_path):
    names = dict(zip(NAMES, ("F00", "F01", "F02", "F03"), strict=True))
    groups = [
        {"presetName": "blink_l", "name": "x", "binds": [{"mesh": 0, "index": 0, "weight": 100}]},
        {"presetName": "a", "name": "x", "binds": [{"mesh": 0, "index": 2, "weight": 100}]},
        {"presetName": "unknown", "name": "TongueOut", "binds": [{"mesh": 0, "index": 3, "weight": 100}]},
        {"presetName": "joy", "name": "Joy", "binds": [{"mesh": 0, "index": 1, "weight": 100}]},
    ]
    old = {"VRM": {"blendShapeMaster": {"blendShapeGroups": groups}}}
    path = avatar(tmp_path / "a.vrm", names.get, extensions=old)
    wanted = {"F00": "eyeBlinkLeft", "F02": "jawOpen", "F03": "tongueOut"}
    assert expression_pairs(path, NAMES) == wanted
    binds = {n: {"morphTargetBinds": [{"node": 0, "index": i, "weight": 1.0}]} for n, i in
             (("blinkLeft", 0), ("aa", 2), ("tongueOut", 3), ("happy", 1))}  # fmt: skip
    custom = {"tongueOut": binds.pop("tongueOut")}
    new = {"VRMC_vrm": {"expressions": {"preset": binds, "custom": custom}}}
    assert expression_pairs(avatar(tmp_path / "b.vrm", names.get, extensions=new), NAMES) == wanted
    play_on(nod("tongueOut"), path, tmp_path / "o.glb", {})
    assert [row.any() for row in read_performance(tmp_path / "o.glb").weights.T] == [True, False, True, True]


def test_a_live_link_file_plays_on_it(tmp_path):
    rows = [f"10:00:00:{i:02d}.0,61,{i / 30},0,0,0.2" for i in range(30)]
    (tmp_path / "a.csv").write_text(
        "\n".join(["Timecode,BlendShapeCount,JawOpen,EyeBlinkLeft,EyeBlinkRight,HeadYaw", *rows])
    )
    mien("convert", tmp_path / "a.csv", output=tmp_path / "o.glb", rig=avatar(tmp_path / "a.glb"))
    back = read_performance(tmp_path / "o.glb")
    np.testing.assert_allclose(back.weights[:, 2], np.arange(30) / 30, atol=1e-6)


def test_the_builder_keeps_what_it_is_given(tmp_path):
    """The file's own bytes stand first, unchanged."""
    source = avatar(tmp_path / "a.glb")
    play_on(nod(), source, tmp_path / "o.glb", {})
    before, after = open_glb(source).blob, open_glb(tmp_path / "o.glb").blob
    assert after.startswith(before)
    assert struct.unpack_from("<I", (tmp_path / "o.glb").read_bytes())[0] == 0x46546C67
