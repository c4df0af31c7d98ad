"""glTF out and in: round trips, other programs' readers, Khronos's validator, other programs' files, refusals."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from gltf_validator import assert_valid_gltf, gltf_issues
from mien.errors import BadInput
from mien.io.gltf import read_performance, read_rig, write_performance, write_rig
from mien.io.gltf.glb import GlbBuilder, open_glb
from mien.io.gltf.mesh import linear_from_srgb, split_seams, srgb_from_linear
from mien.mesh import Mesh
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector


def cap(size: int = 12) -> Mesh:
    """A curved grid of a face's size with a texture seam down the middle, and one vertex that no triangle uses."""
    u, v = np.meshgrid(np.linspace(-1, 1, size), np.linspace(-1, 1, size))
    vertices = np.stack([70 * u, 90 * v, 60 - 50 * u**2 - 20 * v**2], -1).reshape(-1, 3)
    i = (np.arange(size - 1)[:, None] * size + np.arange(size - 1)).ravel()
    faces = np.concatenate([np.stack([i, i + 1, i + size], 1), np.stack([i + 1, i + size + 1, i + size], 1)])
    left = vertices[faces].mean(axis=1)[:, 0] < 0
    uv = np.stack([u.ravel() / 2 + 0.5, v.ravel() / 2 + 0.5], 1) * 0.5
    uv_faces = faces + np.where(left, 0, len(uv))[:, None]
    vertices = np.concatenate([vertices, [[1.0, 2.0, 3.0]]])
    return Mesh(vertices, faces, np.concatenate([uv, uv + 0.5]), uv_faces)


def rig(shapes: int = 4, **options) -> Rig:
    """Local and global displacements, one of them nothing at all."""
    rng = np.random.default_rng(3)
    mesh = cap()
    deltas = rng.normal(0, 3, (shapes, len(mesh.vertices), 3))
    deltas[0, 20:] = 0
    deltas[1] = 0
    names = ("jawOpen", "cheekPuff", "mouthSmileLeft", "browInnerUp", *(f"s{i}" for i in range(100)))[:shapes]
    return Rig(mesh, deltas, names, **options)


def performance(frames: int = 30, rate: float = 60.0) -> Performance:
    rng = np.random.default_rng(4)
    angles = np.linspace(0, 7, frames)[:, None] * np.array([0.1, 1.0, 0.2])
    pose = Transform(rotation_from_vector(angles), rng.normal(0, 100, (frames, 3)))
    tracked = np.ones(frames, dtype=bool)
    tracked[1:3] = False
    return Performance(rig(), rng.random((frames, 4)), pose, rate, tracked)


def refusal(read, path: Path) -> str:
    with pytest.raises(BadInput) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def same_rig(a: Rig, b: Rig) -> None:
    np.testing.assert_allclose(a.neutral.vertices, b.neutral.vertices, atol=1e-5)
    np.testing.assert_array_equal(a.neutral.faces, b.neutral.faces)
    np.testing.assert_allclose(a.deltas, b.deltas, atol=2e-6)
    assert a.names == b.names


# --- round trips -------------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("frames", [1, 2])
def test_very_short_performance(tmp_path, frames):
    before = performance(frames=30)
    few = Performance(before.rig, before.weights[:frames], before.T_world_face[:frames], 59.94, np.ones(frames, bool))
    write_performance(tmp_path / "perf.glb", few)
    after = read_performance(tmp_path / "perf.glb")
    np.testing.assert_allclose(after.weights, few.weights, atol=1e-7)
    assert after.rate == 59.94


def test_a_long_performance_keeps_its_frames(tmp_path):
    """float32 times half an hour in are coarse; frames must neither be lost nor doubled."""
    frames = 100_000
    face = Rig(cap(3), np.zeros((1, 10, 3)), ("jawOpen",))
    weights = np.linspace(0, 1, frames)[:, None]
    take = Performance(face, weights, Transform.identity(frames), 59.94, np.ones(frames, bool))
    write_performance(tmp_path / "p.glb", take)
    np.testing.assert_allclose(read_performance(tmp_path / "p.glb").weights, weights, atol=1e-6)


def test_a_scaling_pose_is_refused():
    face = performance(2)
    pose = Transform(face.T_world_face.rotation, face.T_world_face.translation, 1.1)
    with pytest.raises(ValueError, match="rigid pose"):
        write_performance("x.glb", Performance(face.rig, face.weights, pose, 60.0, face.tracked))


# --- what others see ---------------------------------------------------------------------------------------------


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


def test_first_vertices_are_the_rigs_in_its_order(tmp_path):
    before = rig()
    write_rig(tmp_path / "rig.glb", before)
    glb = open_glb(tmp_path / "rig.glb")
    part = glb.json["meshes"][0]["primitives"][0]
    stored = glb.accessor(part["attributes"]["POSITION"])
    n = len(before.neutral.vertices)
    mesh = before.neutral
    seen = np.unique(np.stack([mesh.faces.ravel(), mesh.uv_faces.ravel()]), axis=1)  # pyright: ignore[reportOptionalMemberAccess]
    assert len(stored) == seen.shape[1] + 1
    assert len(stored) > n
    np.testing.assert_allclose(stored[:n] * 1000, before.neutral.vertices, atol=1e-5)
    assert part["attributes"]["TEXCOORD_0"] is not None
    assert glb.json["meshes"][0]["extras"]["targetNames"] == list(before.names)
    shift = glb.accessor(part["targets"][2]["POSITION"])
    np.testing.assert_allclose(shift[:n] * 1000, before.deltas[2], atol=1e-5)


def test_texture_origin_is_turned(tmp_path):
    """glTF counts v from the top of the image, the mesh from the bottom."""
    write_rig(tmp_path / "rig.glb", rig())
    glb = open_glb(tmp_path / "rig.glb")
    uv = glb.accessor(glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"])
    neutral = rig().neutral
    assert neutral.uv is not None
    corner = neutral.uv_faces[0, 0]  # pyright: ignore[reportOptionalSubscript]
    np.testing.assert_allclose(uv[neutral.faces[0, 0]], [neutral.uv[corner, 0], 1 - neutral.uv[corner, 1]], atol=1e-7)


def test_local_shapes_are_stored_sparsely(tmp_path):
    write_rig(tmp_path / "rig.glb", rig())
    glb = open_glb(tmp_path / "rig.glb")
    targets = [t["POSITION"] for t in glb.json["meshes"][0]["primitives"][0]["targets"]]
    assert [("sparse" in glb.json["accessors"][i]) for i in targets] == [True, True, False, False]


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


# --- files of other programs -------------------------------------------------------------------------------------


def f32(values) -> np.ndarray:
    return np.array(values, np.float32)


def foreign(path: Path, **change) -> Path:
    """Two quads in two primitives, two targets, interleaved, turned and scaled by nodes, cubic and step keys."""
    build = GlbBuilder()
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    parts = []
    for shift in (0, 1):
        points = square + f32([shift, 0, 0])
        both = np.concatenate([points, np.tile(f32([[0, 0, 1]]), (4, 1))], axis=1)
        view = build.view(both.tobytes(), 34962)
        build.json["bufferViews"][view]["byteStride"] = 24
        head = {"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3"}
        position = build.add("accessors", head | {"min": points.min(0).tolist(), "max": points.max(0).tolist()})
        normal = build.add("accessors", head | {"byteOffset": 12})
        up = np.zeros((4, 3), np.float32)
        up[:, 1] = 0.5
        targets = [
            {"POSITION": build.accessor(up, bounds=True, name="smile")},
            {"POSITION": build.accessor(-up, bounds=True, name="frown")},
        ]
        indices = build.accessor(np.array([0, 1, 2, 0, 2, 3], np.uint8), 34963)
        parts.append({"attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices, "targets": targets})
    build.add("meshes", {"primitives": [{k: parts[0][k] for k in ("attributes", "indices")}], "name": "plain"})
    build.add("meshes", {"primitives": parts, **change.get("mesh", {})})
    half = np.sqrt(0.5)
    build.add("nodes", {"children": [1], "rotation": [-half, 0, 0, half], "scale": [0.1, 0.1, 0.1]})
    build.add("nodes", {"mesh": 1, "translation": [0, 0, 2]})
    build.add("nodes", {"mesh": 0})
    build.json |= {"scenes": [{"nodes": [0, 2]}], "scene": 0}
    if change.get("animate", True):
        times = build.accessor(f32([0, 0.5, 1.0]), bounds=True)
        tangents = f32([9, 9])
        keys = np.stack([np.stack([tangents, v, tangents]) for v in f32([[0, 0], [1, 0], [0, 1]])])
        weights = build.accessor(np.ascontiguousarray(keys.ravel()))
        moves = build.accessor(f32([[0, 0, 2], [0, 0, 4], [0, 0, 6]]))
        samplers = [
            {"input": times, "output": weights, "interpolation": "CUBICSPLINE"},
            {"input": times, "output": moves, "interpolation": "STEP"},
        ]
        channels = [
            {"sampler": 0, "target": {"node": 1, "path": "weights"}},
            {"sampler": 1, "target": {"node": 1, "path": "translation"}},
        ]
        build.add("animations", {"samplers": samplers, "channels": channels})
    build.save(path)
    return path


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


def test_uneven_keys_are_resampled(tmp_path):
    build = GlbBuilder(json=json.loads(json.dumps(open_glb(foreign(tmp_path / "x.glb", animate=False)).json)))
    build._blob += open_glb(tmp_path / "x.glb").blob
    times = build.accessor(f32([1.0, 1.1, 1.2, 1.5]), bounds=True)
    weights = build.accessor(f32([0, 0, 1, 0, 0, 0, 0.3, 0]))
    build.add(
        "animations",
        {
            "samplers": [{"input": times, "output": weights}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "weights"}}],
        },
    )
    build.save(tmp_path / "uneven.glb")
    read = read_performance(tmp_path / "uneven.glb")
    assert read.rate == 10
    np.testing.assert_allclose(read.weights[:, 0], [0, 1, 0, 0.1, 0.2, 0.3], atol=1e-5)


# --- pieces ------------------------------------------------------------------------------------------------------


def test_split_seams_by_hand():
    mesh = Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 2, 3]]), np.eye(5, 2), np.array([[0, 1, 2], [0, 4, 3]]))
    faces, source, uv = split_seams(mesh)
    np.testing.assert_array_equal(source, [0, 1, 2, 3, 2])
    np.testing.assert_array_equal(faces, [[0, 1, 2], [0, 4, 3]])
    assert uv is not None
    np.testing.assert_array_equal(uv[faces], np.eye(5, 2)[mesh.uv_faces])


def test_srgb_known_values_and_inverse():
    np.testing.assert_allclose(linear_from_srgb(np.array([[0.0, 0.5, 1.0]])), [[0, 0.21404, 1]], atol=1e-5)
    x = np.linspace(0, 1, 99).reshape(-1, 3)
    np.testing.assert_allclose(srgb_from_linear(linear_from_srgb(x)), x, atol=1e-6)


# --- refusals ----------------------------------------------------------------------------------------------------


def test_what_is_not_glb(tmp_path):
    path = tmp_path / "rig.glb"
    assert "no such file" in refusal(read_rig, path)
    for content in (b"", b"glTF", b"hello there, this is no model at all"):
        path.write_bytes(content)
        assert "not a .glb file" in refusal(read_rig, path)
    path.write_bytes(b"glTF" + struct.pack("<II", 1, 40) + bytes(40))
    assert "glTF version 1" in refusal(read_rig, path)


@pytest.mark.parametrize("keep", [0.1, 0.5, 0.9, 0.999])
def test_a_truncated_glb_is_refused(tmp_path, keep):
    write_performance(tmp_path / "perf.glb", performance())
    data = (tmp_path / "perf.glb").read_bytes()
    (tmp_path / "perf.glb").write_bytes(data[: int(keep * len(data))])
    for read in (read_rig, read_performance):
        assert "cut off" in refusal(read, tmp_path / "perf.glb")


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
