import numpy as np
import pytest
import scipy.sparse as sp

from mien.errors import BadInput
from mien.mesh import Attachment, ClosestPoint, Mesh, closest_point, cotangent_laplacian, vertex_normals
from mien.register import (
    Anchors,
    NonrigidConfig,
    Rejection,
    Surface,
    Template,
    register_surface,
)
from mien.register.coarse import CoarseTemplate
from mien.register.residuals import laplacian_term, marker_term, membrane_term, plane_term, point_term
from mien.register.shape import local_rotations, make_stencil, turned_edges
from mien.register.solver import solve_vertices
from mien.transforms import Transform, rotation_from_vector


def hills(n=25, size=100.0, shift=0.0, triangles="same"):
    """A patch with hills of side `size`, mm; `shift` moves the grid over the same hills."""
    u, v = np.meshgrid(np.linspace(-1, 1, n) + shift, np.linspace(-1, 1, n) + shift, indexing="ij")
    z = 0.25 * np.sin(3 * u + 0.5) * np.cos(2.5 * v) + 0.2 * u * v - 0.2 * u**2
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    halves = ((a, b, c), (a, c, d)) if triangles == "same" else ((a, b, d), (b, c, d))
    return Mesh(size / 2 * np.stack([u, v, z], -1).reshape(-1, 3), np.concatenate([np.stack(h, 1) for h in halves]))


def bent(points):
    """A smooth deformation of some millimetres."""
    x, y, _ = (points / 50).T
    return points + np.stack([2 * np.sin(2 * y), 2 * np.cos(1.5 * x), 4 * np.sin(2 * x + 1) * np.cos(2 * y)], 1)


MESH = hills()
STENCIL = make_stencil(MESH.vertices, MESH.faces)


def all_terms(x, mesh=MESH):
    stencil = make_stencil(mesh.vertices, mesh.faces)
    edges = turned_edges(stencil, mesh.vertices, None)
    rng = np.random.default_rng(1)
    weights = rng.random(len(x))
    at = Attachment(np.array([3, 19, 50]), np.array([[0.2, 0.3, 0.5]] * 3))
    return {
        "markers": marker_term(at.matrix(mesh), rng.normal(size=(3, 3)), np.array([1.0, 2, 3])),
        "laplacian": laplacian_term(stencil, edges, 1.0, 1.0),
        "membrane": membrane_term(stencil, edges, 0.1),
        "points": point_term(rng.normal(size=x.shape), weights),
        "planes": plane_term(rng.normal(size=x.shape), vertex_normals(mesh.vertices, mesh.faces), weights),
    }


@pytest.mark.parametrize("name", ["markers", "laplacian", "membrane", "points", "planes"])
def test_derivative_of_each_term(name):
    """The gradient that the solver uses against differences of the cost."""
    rng = np.random.default_rng(2)
    x, way = bent(MESH.vertices), rng.normal(size=MESH.vertices.shape)
    term = all_terms(x)[name]
    r = term.residual(x)
    slope = (term.normals * r[:, None] * way).sum() if name == "planes" else ((term.matrix @ way) * r).sum()
    h = 1e-5
    np.testing.assert_allclose((term.cost(x + h * way) - term.cost(x - h * way)) / (2 * h), 2 * slope, rtol=1e-5)


def test_terms_by_hand():
    x = np.array([[0.0, 0, 0], [1, 0, 0]])
    planes = plane_term(np.array([[0.0, 0, 3], [0, 0, 4]]), np.array([[0.0, 0, 1], [1, 0, 0]]), np.array([2.0, 9.0]))
    np.testing.assert_allclose(planes.cost(x), 2 * 9 + 9 * 1)
    np.testing.assert_allclose(point_term(x + np.array([0, 0, 2]), np.array([1.0, 3.0])).cost(x), 4 + 12)
    middle = sp.csr_matrix(np.array([[0.5, 0.5]]))
    np.testing.assert_allclose(marker_term(middle, np.array([[0.5, 2, 0]]), np.array([5.0])).cost(x), 20)


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


def test_a_template_that_cannot_be_decimated_is_refused():
    mesh = hills(61)
    fin = np.concatenate([mesh.vertices, mesh.vertices[:1] + 5])
    forked = Mesh(fin, np.concatenate([mesh.faces, [[*mesh.faces[700, :2], len(fin) - 1]]]))
    mixed = Mesh(mesh.vertices, np.where(np.arange(len(mesh.faces))[:, None] % 7, mesh.faces, mesh.faces[:, ::-1]))
    for wrong in (forked, mixed):
        with pytest.raises(BadInput, match="more than two triangles or mixed winding"):
            Template(wrong, coarse_vertices=500)
        Template(wrong, coarse_vertices=0)


def _plane_rows(term, n):
    rows = np.zeros((n, 3 * n))
    for i in range(n):
        rows[i, 3 * i : 3 * i + 3] = term.normals[i]
    return rows


def test_a_template_meets_a_surface_of_other_triangles():
    target = hills(61, shift=0.007, triangles="other")
    target = target.with_vertices(bent(target.vertices))
    inner = hills(25, size=80.0)
    inner = inner.with_vertices(MESH.vertices * 0.8)
    inner = inner.with_vertices(closest_point(hills(61), inner.vertices).points)
    found = register_surface(inner, target)
    off = found.vertices - bent(inner.vertices)
    assert found.distances[found.accepted].mean() < 0.05
    assert found.accepted.mean() > 0.9
    normals = vertex_normals(found.vertices, inner.faces)
    across = np.abs(np.einsum("nd,nd->n", off, normals))[found.accepted]
    assert across.mean() < 0.1 * np.linalg.norm(bent(inner.vertices) - inner.vertices, axis=1).mean()
    assert np.linalg.norm(off, axis=1).mean() < np.linalg.norm(bent(inner.vertices) - inner.vertices, axis=1).mean()


def test_markers_are_met_and_carry_the_rest():
    """Markers on a smooth deformation bring most of it along, tangential part included (eq. 7, first two terms)."""
    truth = bent(MESH.vertices)
    rng = np.random.default_rng(3)
    faces = rng.choice(len(MESH.faces), 40, replace=False)
    at = Attachment(faces, np.full((40, 3), 1 / 3))
    anchors = Anchors(at, at.points(MESH.with_vertices(truth)), np.ones(40))
    found = register_surface(MESH, MESH.with_vertices(truth), anchors, NonrigidConfig(coarse=()))
    np.testing.assert_allclose(at.points(MESH.with_vertices(found.vertices)), anchors.points, atol=0.05)
    inner = np.abs(MESH.vertices[:, :2]).max(axis=1) < 40
    before = np.linalg.norm(MESH.vertices - truth, axis=1)[inner].mean()
    assert np.linalg.norm(found.vertices - truth, axis=1)[inner].mean() < 0.15 * before
    assert set(found.costs) == {"laplacian", "membrane", "markers", "closest"}


def test_registration_moves_with_its_input():
    T = Transform(rotation_from_vector(np.array([0.5, 1.0, -0.4])), np.array([10.0, -20, 30]))
    target = MESH.with_vertices(bent(MESH.vertices))
    plain = register_surface(MESH, target, config=NonrigidConfig(coarse=(0.01,)))
    turned = register_surface(
        MESH.with_vertices(T.apply(MESH.vertices)),
        target.with_vertices(T.apply(target.vertices)),
        config=NonrigidConfig(coarse=(0.01,)),
    )
    np.testing.assert_allclose(turned.vertices, T.apply(plain.vertices), atol=0.02)


def test_trust_zero_is_not_pulled():
    target = MESH.with_vertices(MESH.vertices + np.array([0, 0, 3.0]))
    trust = (MESH.vertices[:, 0] > 0).astype(float)
    found = register_surface(MESH, target, config=NonrigidConfig(plane=0.0), trust=trust * 0)
    np.testing.assert_allclose(found.vertices, MESH.vertices, atol=1e-6)
    free = Rejection(boundary=False, max_distance=5.0)
    half = register_surface(MESH, target, config=NonrigidConfig(coarse=(), rejection=free), trust=trust)
    assert half.distances[MESH.vertices[:, 0] > 0].max() < 0.3


def test_correspondences_of_some_among_all():
    target = hills(9)
    some = np.array([3, 7])
    found = Surface(target).correspond(target.vertices[some] + 0.1, vertex_normals(target.vertices, target.faces)[some])
    among = found.among(10, some)
    np.testing.assert_array_equal(among.points[some], found.points)
    np.testing.assert_array_equal(np.flatnonzero(among.accepted), some[found.accepted])
    assert among.points.shape == (10, 3)
    assert not among.normals[np.setdiff1d(np.arange(10), some)].any()


def test_a_decimated_template_takes_the_stiff_rounds():
    fine = hills(61)
    target = fine.with_vertices(bent(fine.vertices))
    found = Template(fine, coarse_vertices=600).register(ClosestPoint(target))
    assert found.distances[found.accepted].mean() < 0.05
    assert found.rounds == 18


def folded(n=61):
    """A strip bent over like a closed mouth: two sheets 0.2 mm apart, joined by a rim at the back; and each's side."""
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(0, 1, n), indexing="ij")
    side = np.tanh(u / 0.05)
    flat = np.stack([50 * np.abs(u), 60 * v, 0.1 * side], -1).reshape(-1, 3)
    return Mesh(flat, hills(n).faces), side.reshape(-1)


def test_sheets_that_touch_part_again():
    """Sheets open by up to 10 mm each: a coarse stand-in that looked for the closest point would tear them."""
    mesh, side = folded()
    coarse = CoarseTemplate(mesh, 500)
    opened = mesh.vertices + np.stack([np.zeros(len(side)), np.zeros(len(side)), side * mesh.vertices[:, 0] / 5], 1)
    found = coarse.up(coarse.down(opened))
    away = mesh.vertices[:, 0] > 5
    assert np.linalg.norm(found - opened, axis=1)[away].max() < 1.0
    assert (np.sign(found[away, 2]) == np.sign(side[away])).all()
    at = Attachment(np.arange(len(mesh.faces)), np.full((len(mesh.faces), 3), 1 / 3))
    there = coarse.attachment(at).points(coarse.mesh.with_vertices(coarse.down(opened)))
    sides = at.points(mesh.with_vertices(opened))[:, 2]
    assert (np.sign(there[:, 2]) == np.sign(sides))[np.abs(sides) > 1].all()
