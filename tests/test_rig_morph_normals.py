"""Normals of shapes."""

import numpy as np

from gltf_files import rig
from mien.mesh import vertex_normals
from mien.rig.morph_normals import neutral_normals, normal_offsets


def test_a_shape_at_one_has_its_own_normals():
    face = rig()
    rest = neutral_normals(face)
    used = np.unique(face.neutral.faces)
    alone = np.setdiff1d(np.arange(len(face.neutral.vertices)), used)
    for k in range(len(face.names)):
        true = vertex_normals(face.neutral.vertices + face.deltas[k], face.neutral.faces)
        np.testing.assert_allclose((rest + normal_offsets(face, k, rest))[used], true[used], atol=2e-4)
        assert not normal_offsets(face, k, rest)[alone].any()
    assert not normal_offsets(face, 1, rest).any()
    np.testing.assert_allclose(rest[alone], [[0, 0, 1]])
