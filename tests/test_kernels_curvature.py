"""Patches against their numpy twin."""

import numpy as np

from curved_meshes import height_field
from mien._kernels import curvature as kernels
from mien._kernels import curvature_twin as twins
from mien.mesh import adjacency, boundary_vertices, vertex_normals


def test_kernel_and_twin_agree():
    rng = np.random.default_rng(0)
    mesh = height_field(lambda x, y: np.sin(0.3 * x) + 0.02 * rng.standard_normal(x.shape), count=15)
    A = adjacency(mesh.faces, len(mesh.vertices))
    arguments = [mesh.vertices, vertex_normals(mesh.vertices, mesh.faces), A.indptr.astype(np.int64)]
    arguments += [A.indices.astype(np.int64), 6.0]
    compiled, plain = kernels.patch_curvature(*arguments), twins.patch_curvature(*arguments)
    assert len(boundary_vertices(mesh.faces))
    np.testing.assert_allclose(compiled, plain, atol=1e-8)
    assert np.abs(plain).max() > 0.01
