"""The linear solver of the nonrigid registration."""

import numpy as np
import pytest

from hilly_meshes import all_terms, bent, hills
from mien.mesh import Attachment, vertex_normals
from mien.register.coarse import CoarseTemplate
from mien.register.residuals import laplacian_term, marker_term, membrane_term, plane_term, point_term
from mien.register.shape import make_stencil, turned_edges
from mien.register.solver import solve_vertices


@pytest.mark.parametrize("factor_up_to", [10_000, 0])
def test_both_preconditioners_reach_the_dense_answer(factor_up_to):
    small = hills(7)
    x = bent(small.vertices)
    terms = all_terms(x, small)
    points = [terms[name] for name in ("markers", "laplacian", "membrane", "points")]
    solved = solve_vertices(points, terms["planes"], x, damping=0.0, factor_up_to=factor_up_to, iterations=3000,
                            tolerance=1e-9)  # fmt: skip
    n = len(x)
    dense = np.vstack([np.kron(t.matrix.toarray(), np.eye(3)) for t in points] + [_plane_rows(terms["planes"], n)])
    rhs = np.concatenate([t.target.ravel() for t in points] + [terms["planes"].offsets])
    expected = np.linalg.lstsq(dense, rhs, rcond=None)[0].reshape(-1, 3)
    assert solved.converged
    np.testing.assert_allclose(solved.vertices, expected, atol=1e-4)


def test_a_coarser_mesh_beside_the_diagonal_saves_iterations():
    """The same answer as without, in far fewer steps."""
    mesh = hills(61)
    x = bent(mesh.vertices)
    stencil = make_stencil(mesh.vertices, mesh.faces)
    at = Attachment(np.arange(0, 7200, 300), np.full((24, 3), 1 / 3))
    edges = turned_edges(stencil, mesh.vertices, None)
    markers = marker_term(at.matrix(mesh), at.points(mesh.with_vertices(x)), np.full(24, 100.0))
    shape = [laplacian_term(stencil, edges, 1.0, 1.0), membrane_term(stencil, edges, 0.02)]
    terms = [*shape, markers, point_term(x, 0.01 * stencil.mass)]
    planes = plane_term(x, vertex_normals(x, mesh.faces), 0.09 * stencil.mass)
    coarse = CoarseTemplate(mesh, 700).prolongation
    exact = solve_vertices(terms, planes, mesh.vertices, tolerance=1e-8, iterations=5000).vertices
    settings = {"factor_up_to": 0, "iterations": 60}
    alone = solve_vertices(terms, planes, mesh.vertices, **settings)
    beside = solve_vertices(terms, planes, mesh.vertices, prolongation=coarse, **settings)
    off, off_alone = (np.linalg.norm(found.vertices - exact, axis=1).mean() for found in (beside, alone))
    assert off < 0.4 * off_alone


def _plane_rows(term, n):
    rows = np.zeros((n, 3 * n))
    for i in range(n):
        rows[i, 3 * i : 3 * i + 3] = term.normals[i]
    return rows
