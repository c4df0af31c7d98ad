"""A face cut along the middle is made whole by its mirror image."""

import numpy as np

from mien.faces.bundled import load_face
from mien.landmarks.half_face import completed, cut_planes
from mien.mesh import Mesh, Scan, submesh


def test_the_cut_is_found_and_the_other_half_mirrored():
    mesh = load_face().rig.neutral
    half, _ = submesh(Mesh(mesh.vertices, mesh.faces), mesh.vertices[mesh.faces, 0].min(axis=1) > -1)
    planes = [p for p in cut_planes(half) if abs(p.normal[0]) > 0.99]
    assert planes
    assert (planes[0].height(half.vertices) > -3).all()
    whole = completed(Scan(half), planes[0]).mesh
    assert len(whole.vertices) == 2 * len(half.vertices)
    np.testing.assert_allclose(whole.vertices[:, 0].min(), -whole.vertices[:, 0].max(), atol=3)


def test_a_mesh_without_a_rim_has_no_cut():
    tetrahedron = Mesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    )
    assert cut_planes(tetrahedron) == []
