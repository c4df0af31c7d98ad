"""Rigs, performances and files of other programs for glTF."""

from pathlib import Path

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.gltf.glb import GlbBuilder
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


def same_rig(a: Rig, b: Rig) -> None:
    np.testing.assert_allclose(a.neutral.vertices, b.neutral.vertices, atol=1e-5)
    np.testing.assert_array_equal(a.neutral.faces, b.neutral.faces)
    np.testing.assert_allclose(a.deltas, b.deltas, atol=2e-6)
    assert a.names == b.names
