"""glTF's node tree by hand: who stands above the face, and where that puts it."""

from pathlib import Path

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.gltf.glb import Glb
from mien.io.gltf.scene import chain_of, default_matrix, global_matrix, head_joint, morph_mesh_node, node_matrices

QUARTER = [0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]
"""A quarter turn about +Y."""


def glb(nodes, **more):
    return Glb(Path("a.glb"), {"nodes": nodes, **more}, b"")


def test_a_chain_runs_from_the_root_down_and_its_matrices_multiply():
    tree = glb(
        [{"children": [1], "translation": [1, 0, 0]}, {"children": [2], "rotation": QUARTER}, {"scale": [2] * 3}]
    )
    assert chain_of(tree, 2) == [0, 1, 2]
    point = default_matrix(tree, [0, 1, 2]) @ [1.0, 0, 0, 1]
    np.testing.assert_allclose(point, [1, 0, -2, 1], atol=1e-12)
    np.testing.assert_allclose(global_matrix(tree, 2), default_matrix(tree, [0, 1, 2]))
    assert chain_of(tree, None) == []


def test_a_node_that_is_its_own_ancestor_is_refused():
    with pytest.raises(BadInput, match="its own ancestor"):
        chain_of(glb([{"children": [1]}, {"children": [0]}]), 0)


def test_animation_replaces_what_the_node_says():
    node = {"translation": [1.0, 0, 0], "scale": [3.0, 3, 3]}
    moved = node_matrices(node, {"translation": np.array([[0.0, 5, 0], [0, 6, 0]])}, 2)
    np.testing.assert_array_equal(moved[:, :3, 3], [[0, 5, 0], [0, 6, 0]])
    np.testing.assert_array_equal(moved[1, :3, :3], 3 * np.eye(3))
    by_columns = node_matrices({"matrix": list(np.arange(16.0))}, {}, 1)[0]
    assert by_columns[0, 3] == 12


def test_the_mesh_with_most_targets_is_the_face():
    parts = [{"targets": [{}] * n, "attributes": {"POSITION": 0}} for n in (2, 5)]
    accessors = [{"count": 9}]
    meshes = [{"primitives": [part]} for part in parts]
    tree = glb([{"mesh": 1}, {"mesh": 0}], meshes=meshes, accessors=accessors)
    assert morph_mesh_node(tree) == (0, meshes[1])
    with pytest.raises(BadInput, match="has no morph targets"):
        morph_mesh_node(glb([], meshes=[{"primitives": [{}]}]))


@pytest.mark.parametrize(
    ("names", "found"),
    [(("Hips", "Neck", "mixamorig:Head"), 2), (("Hips", "Neck_01", "Eye"), 1), (("A", "B", "C"), None)],
)
def test_the_head_s_bone_is_known_by_its_name(names, found):
    tree = glb([*({"name": name} for name in names), {"mesh": 0, "skin": 0}], skins=[{"joints": [0, 1, 2]}],
               meshes=[{"primitives": [{}]}])  # fmt: skip
    assert head_joint(tree, 3) == found
