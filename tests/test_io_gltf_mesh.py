"""Meshes in glTF: seams, colours, the texture's origin."""

import numpy as np

from gltf_files import rig
from mien.io.gltf import write_rig
from mien.io.gltf.glb import open_glb
from mien.io.gltf.mesh import linear_from_srgb, split_seams, srgb_from_linear
from mien.mesh import Mesh


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
