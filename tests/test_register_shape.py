"""The shape term: stencils and turns."""

import numpy as np

from hilly_meshes import MESH, bent, hills
from mien.mesh import cotangent_laplacian
from mien.register.residuals import laplacian_term
from mien.register.shape import local_rotations, make_stencil, turned_edges
from mien.transforms import rotation_from_vector

STENCIL = make_stencil(MESH.vertices, MESH.faces)


def test_stencil_is_the_cotangent_laplacian():
    L = STENCIL.incidence.T @ STENCIL.incidence
    flat = hills(9)
    acute = make_stencil(flat.vertices * [1, 1, 0], flat.faces)
    expected = cotangent_laplacian(flat.vertices * [1, 1, 0], flat.faces)
    off = acute.incidence.T @ acute.incidence - expected
    assert abs(off).max() < 0.01
    np.testing.assert_allclose(L @ np.ones(len(MESH.vertices)), 0, atol=1e-12)


def test_a_turned_template_costs_nothing_when_turns_are_followed():
    R = rotation_from_vector(np.array([0.3, -0.8, 0.5]))
    x = MESH.vertices @ R.T
    turns = local_rotations(STENCIL, MESH.vertices, x)
    np.testing.assert_allclose(turns, np.broadcast_to(R, turns.shape), atol=1e-6)
    followed = laplacian_term(STENCIL, turned_edges(STENCIL, MESH.vertices, turns), 1.0, 1.0)
    plain = laplacian_term(STENCIL, turned_edges(STENCIL, MESH.vertices, None), 1.0, 1.0)
    assert followed.cost(x) < 1e-9
    assert plain.cost(x) > 1.0


def test_bending_means_the_same_on_finer_meshes():
    """A deformation costs the same, whatever the density; without the masses it would not."""
    costs = []
    for n in (41, 81):
        mesh = hills(n)
        stencil = make_stencil(mesh.vertices, mesh.faces)
        inner = np.abs(mesh.vertices[:, :2]).max(axis=1) < 40
        term = laplacian_term(stencil, turned_edges(stencil, mesh.vertices, None), 1.0, 1.0)
        costs.append((term.residual(bent(mesh.vertices))[inner] ** 2).sum())
    np.testing.assert_allclose(costs[0], costs[1], rtol=0.15)
