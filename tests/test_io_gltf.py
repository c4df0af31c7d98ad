"""glTF out and in: round trips, other programs' readers, Khronos's validator, other programs' files, refusals."""

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from gltf_files import cap, foreign, performance, refusal, rig, same_rig
from gltf_validator import assert_valid_gltf, gltf_issues
from mien.errors import BadInput
from mien.io.gltf import read_performance, read_rig, write_performance, write_rig
from mien.io.gltf.glb import GlbBuilder, open_glb
from mien.mesh import Mesh
from mien.rig import Performance, Rig
from mien.transforms import Transform


def test_rig_round_trip_across_seams(tmp_path):
    before = rig()
    write_rig(tmp_path / "rig.glb", before)
    after = read_rig(tmp_path / "rig.glb")
    same_rig(after, before)
    a, b = after.neutral, before.neutral
    assert a.uv is not None
    assert b.uv is not None
    np.testing.assert_allclose(a.uv[a.uv_faces], b.uv[b.uv_faces], atol=1e-7)
    assert after.texture is None


def test_rig_without_uv_and_with_colours(tmp_path):
    mesh = cap()
    colors = np.random.default_rng(0).random((len(mesh.vertices), 3))
    before = Rig(Mesh(mesh.vertices, mesh.faces, colors=colors), rig().deltas, rig().names)
    write_rig(tmp_path / "rig.glb", before)
    after = read_rig(tmp_path / "rig.glb")
    same_rig(after, before)
    assert after.neutral.uv is None
    assert after.neutral.colors is not None
    np.testing.assert_allclose(after.neutral.colors, colors, atol=1e-6)


def test_rig_with_uv_by_vertex_keeps_it_so(tmp_path):
    mesh = cap()
    uv = np.random.default_rng(0).random((len(mesh.vertices), 2))
    before = Rig(Mesh(mesh.vertices, mesh.faces, uv), rig().deltas, rig().names)
    write_rig(tmp_path / "rig.glb", before)
    after = read_rig(tmp_path / "rig.glb").neutral
    assert after.uv_faces is None
    assert after.uv is not None
    np.testing.assert_allclose(after.uv, uv, atol=1e-7)


def test_texture_is_kept_to_the_bit_beside_colours(tmp_path):
    texture = np.random.default_rng(0).integers(0, 256, (8, 16, 3), dtype=np.uint8)
    plain = rig(texture=texture)
    colors = np.full((len(plain.neutral.vertices), 3), 0.25)
    mesh = Mesh(plain.neutral.vertices, plain.neutral.faces, plain.neutral.uv, plain.neutral.uv_faces, colors)
    write_rig(tmp_path / "rig.glb", Rig(mesh, plain.deltas, plain.names, texture))
    after = read_rig(tmp_path / "rig.glb")
    np.testing.assert_array_equal(after.texture, texture)
    assert after.neutral.colors is not None
    np.testing.assert_allclose(after.neutral.colors, colors, atol=1e-6)
    attributes = open_glb(tmp_path / "rig.glb").json["meshes"][0]["primitives"][0]["attributes"]
    assert "COLOR_0" not in attributes


def test_performance_round_trip(tmp_path):
    before = performance()
    write_performance(tmp_path / "perf.glb", before)
    after = read_performance(tmp_path / "perf.glb")
    same_rig(after.rig, before.rig)
    np.testing.assert_allclose(after.weights, before.weights, atol=1e-7)
    np.testing.assert_allclose(after.T_world_face.rotation, before.T_world_face.rotation, atol=1e-6)
    np.testing.assert_allclose(after.T_world_face.translation, before.T_world_face.translation, atol=1e-4)
    np.testing.assert_array_equal(after.tracked, before.tracked)
    assert after.rate == 60
    same_rig(read_rig(tmp_path / "perf.glb"), before.rig)


def test_a_scaling_pose_is_refused():
    face = performance(2)
    pose = Transform(face.T_world_face.rotation, face.T_world_face.translation, 1.1)
    with pytest.raises(ValueError, match="rigid pose"):
        write_performance("x.glb", Performance(face.rig, face.weights, pose, 60.0, face.tracked))


def test_trimesh_sees_the_same_face_in_metres(tmp_path):
    before = rig(texture=np.full((4, 4, 3), 200, np.uint8))
    write_rig(tmp_path / "rig.glb", before)
    scene = trimesh.load_scene(tmp_path / "rig.glb", process=False)
    (geometry,) = scene.geometry.values()
    corners = geometry.vertices[geometry.faces] * 1000
    np.testing.assert_allclose(corners, before.neutral.vertices[before.neutral.faces], atol=1e-4)
    mesh = before.neutral
    assert mesh.uv is not None
    np.testing.assert_allclose(geometry.visual.uv[geometry.faces], mesh.uv[mesh.uv_faces], atol=1e-6)


def test_khronos_validator_finds_nothing(tmp_path):
    texture = np.random.default_rng(0).integers(0, 256, (8, 8, 3), dtype=np.uint8)
    write_performance(tmp_path / "a.glb", performance())
    assert_valid_gltf(tmp_path / "a.glb")
    write_rig(tmp_path / "b.glb", rig(texture=texture))
    assert_valid_gltf(tmp_path / "b.glb")
    colored = Mesh(cap().vertices, cap().faces, colors=np.random.default_rng(0).random((145, 3)))
    write_rig(tmp_path / "c.glb", Rig(colored, rig().deltas, rig().names))
    assert_valid_gltf(tmp_path / "c.glb")


def test_the_validator_helper_can_fail(tmp_path):
    build = GlbBuilder()
    build.add("meshes", {"primitives": [{"attributes": {"POSITION": 7}}]})
    build.view(b"1234")
    build.save(tmp_path / "bad.glb")
    assert gltf_issues(tmp_path / "bad.glb")["numErrors"] > 0


def test_a_foreign_rig(tmp_path):
    """By hand: the root turns z into y and shrinks to a tenth; the shared edge of the two quads becomes one."""
    read = read_rig(foreign(tmp_path / "rig.glb"))
    assert read.names == ("smile", "frown")
    assert len(read.neutral.vertices) == 6
    assert len(read.neutral.faces) == 4
    corners = np.unique(read.neutral.vertices.round(3), axis=0)
    np.testing.assert_allclose(corners[0], [0, 200, -100], atol=1e-4)
    np.testing.assert_allclose(corners[-1], [200, 200, 0], atol=1e-4)
    np.testing.assert_allclose(read.deltas[0], np.tile([0, 0, -50.0], (6, 1)), atol=1e-4)


def test_foreign_names_in_extras_win(tmp_path):
    path = foreign(tmp_path / "rig.glb", mesh={"extras": {"targetNames": ["jawOpen", "jawLeft"]}})
    assert read_rig(path).names == ("jawOpen", "jawLeft")


def test_a_foreign_performance(tmp_path):
    read = read_performance(foreign(tmp_path / "perf.glb"))
    assert read.rate == 2
    np.testing.assert_allclose(read.weights, [[0, 0], [1, 0], [0, 1]], atol=1e-7)
    np.testing.assert_allclose(read.T_world_face.translation, [[0, 0, 0], [0, 200, 0], [0, 400, 0]], atol=1e-3)
    np.testing.assert_allclose(read.T_world_face.rotation, np.tile(np.eye(3), (3, 1, 1)), atol=1e-6)
    assert read.tracked.all()


def rewritten(path: Path, change) -> Path:
    """A written rig with its JSON changed by hand."""
    write_rig(path, rig())
    glb = open_glb(path)
    change(glb.json)
    build = GlbBuilder(json={k: v for k, v in glb.json.items() if k != "buffers"})
    build._blob += glb.blob
    build.save(path)
    return path


def test_rigs_that_do_not_add_up(tmp_path):
    path = tmp_path / "rig.glb"

    def fewer(json):
        json["accessors"][json["meshes"][0]["primitives"][0]["targets"][2]["POSITION"]]["count"] -= 5

    assert "mouthSmileLeft has 162 vertices, the neutral 167" in refusal(read_rig, rewritten(path, fewer))

    def nothing(json):
        del json["meshes"][0]["primitives"][0]["targets"]

    assert "no morph targets" in refusal(read_rig, rewritten(path, nothing))

    def one_name(json):
        json["meshes"][0]["extras"]["targetNames"] = ["jawOpen"]

    assert "has 4 morph targets but 1 targetNames" in refusal(read_rig, rewritten(path, one_name))

    def same_name(json):
        json["meshes"][0]["extras"]["targetNames"] = ["a", "b", "b", "c"]

    assert "two morph targets are named b" in refusal(read_rig, rewritten(path, same_name))

    def compressed(json):
        json["extensionsUsed"] = ["KHR_draco_mesh_compression"]

    assert "without compression" in refusal(read_rig, rewritten(path, compressed))

    def lines(json):
        json["meshes"][0]["primitives"][0]["mode"] = 1

    assert "not made of triangles" in refusal(read_rig, rewritten(path, lines))

    def lost(json):
        json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 99

    assert "damaged" in refusal(read_rig, rewritten(path, lost))

    def long(json):
        json["bufferViews"][0]["byteLength"] = 10**9

    assert "cut off" in refusal(read_rig, rewritten(path, long))

    def elsewhere(json):
        json["bufferViews"][0]["buffer"] = 1

    assert "outside its own binary chunk" in refusal(read_rig, rewritten(path, elsewhere))

    def overlong(json):
        json["accessors"][0]["count"] = 10**6

    assert "longer than its buffer view" in refusal(read_rig, rewritten(path, overlong))


def test_a_rig_is_no_performance(tmp_path):
    write_rig(tmp_path / "rig.glb", rig())
    assert "no animation moves its morph weights" in refusal(read_performance, tmp_path / "rig.glb")


def test_broken_bytes_never_end_in_another_error(tmp_path):
    """Any byte of the JSON flipped: read, or refused with a line."""
    write_performance(tmp_path / "perf.glb", performance(3))
    data = (tmp_path / "perf.glb").read_bytes()
    json_length = struct.unpack_from("<I", data, 12)[0]
    rng = np.random.default_rng(5)
    refused = 0
    for place in rng.integers(20, 20 + json_length, 250):
        broken = bytearray(data)
        broken[place] = rng.integers(32, 127)
        (tmp_path / "broken.glb").write_bytes(broken)
        try:
            read_performance(tmp_path / "broken.glb")
        except BadInput:
            refused += 1
    assert refused > 20


def test_a_failed_write_leaves_the_old_file(tmp_path):
    write_rig(tmp_path / "rig.glb", rig())
    before = (tmp_path / "rig.glb").read_bytes()
    broken = Rig(cap(), np.full((1, 145, 3), np.nan), ("jawOpen",))
    with pytest.raises(ValueError, match="JSON"):
        write_rig(tmp_path / "rig.glb", broken)
    assert (tmp_path / "rig.glb").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["rig.glb"]
