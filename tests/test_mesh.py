import numpy as np
import pytest

from mien.mesh import (
    Attachment,
    ClosestPoint,
    Mesh,
    adjacency,
    barycentric,
    boundary_vertices,
    closest_point,
    cotangent_laplacian,
    face_areas,
    face_normals,
    mass,
    mean_edge_length,
    submesh,
    uniform_laplacian,
    vertex_normals,
)

RNG = np.random.default_rng(1)
RIGHT = Mesh(np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0]]), np.array([[0, 1, 2]]))


def grid(n: int = 6) -> Mesh:
    """A flat square of n x n vertices, 1 mm apart."""
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], 1).astype(float)
    a = (np.arange(n * (n - 1)).reshape(n - 1, n)[:, :-1]).ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)]))


def test_one_right_triangle_by_hand():
    v, f = RIGHT.vertices, RIGHT.faces
    np.testing.assert_allclose(face_areas(v, f), [6])
    np.testing.assert_allclose(mass(v, f), [2, 2, 2])
    np.testing.assert_allclose(face_normals(v, f), [[0, 0, 1]])
    np.testing.assert_allclose(mean_edge_length(v, f), 4)
    # cot of the right angle is 0, of the others 4/3 (at (4,0)) and 3/4 (at (0,3))
    L = cotangent_laplacian(v, f).toarray()
    np.testing.assert_allclose(L[0, 1], -3 / 4 / 2)
    np.testing.assert_allclose(L[0, 2], -4 / 3 / 2)
    np.testing.assert_allclose(L[1, 2], 0, atol=1e-12)


def test_laplacians_vanish_on_constants_and_the_cotangent_one_inside_a_plane_on_linear_functions():
    mesh = grid()
    n = len(mesh.vertices)
    for L in (cotangent_laplacian(mesh.vertices, mesh.faces), uniform_laplacian(mesh.faces, n)):
        np.testing.assert_allclose(L @ np.ones(n), 0, atol=1e-12)
        np.testing.assert_allclose((L - L.T).toarray(), 0, atol=1e-12)
    inside = np.setdiff1d(np.arange(n), boundary_vertices(mesh.faces))
    linear = mesh.vertices @ np.array([2.0, -3, 0])
    np.testing.assert_allclose((cotangent_laplacian(mesh.vertices, mesh.faces) @ linear)[inside], 0, atol=1e-12)


def test_adjacency_and_boundary_of_a_grid():
    mesh = grid(4)
    assert boundary_vertices(mesh.faces).tolist() == [0, 1, 2, 3, 4, 7, 8, 11, 12, 13, 14, 15]
    A = adjacency(mesh.faces, 16).toarray()
    assert A[0].nonzero()[0].tolist() == [1, 4]
    np.testing.assert_array_equal(A, A.T)


def test_degenerate_triangles_leave_the_laplacian_finite():
    flat = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    L = cotangent_laplacian(flat, np.array([[0, 1, 2], [0, 1, 3]]))
    assert np.isfinite(L.toarray()).all()


def test_vertex_normals_turn_with_the_mesh(rotation):
    mesh = Mesh(RNG.normal(size=(30, 3)), RNG.permutation(30).reshape(10, 3))
    turned = vertex_normals(mesh.vertices @ rotation.T, mesh.faces)
    np.testing.assert_allclose(turned, vertex_normals(mesh.vertices, mesh.faces) @ rotation.T, atol=1e-12)


@pytest.fixture
def rotation():
    q, _ = np.linalg.qr(RNG.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def test_closest_point_by_hand():
    found = closest_point(RIGHT, np.array([[1.0, 1, 5], [-1, -1, 0], [2, -2, 0]]))
    np.testing.assert_allclose(found.distances, [5, np.sqrt(2), 2])
    np.testing.assert_allclose(found.points, [[1, 1, 0], [0, 0, 0], [2, 0, 0]], atol=1e-12)
    weights = [[1 - 1 / 4 - 1 / 3, 1 / 4, 1 / 3], [1, 0, 0], [0.5, 0.5, 0]]
    np.testing.assert_allclose(found.barycentric, weights, atol=1e-12)


def test_closest_point_beats_every_sampled_point():
    mesh = Mesh(RNG.normal(size=(60, 3)), np.arange(60).reshape(20, 3))
    queries = RNG.normal(size=(15, 3)) * 2
    found = ClosestPoint(mesh).query(queries)
    weights = RNG.dirichlet(np.ones(3), size=500)
    samples = np.einsum("sc,fcd->fsd", weights, mesh.vertices[mesh.faces]).reshape(-1, 3)
    sampled = np.linalg.norm(queries[:, None] - samples, axis=2).min(axis=1)
    assert (found.distances <= sampled + 1e-12).all()
    np.testing.assert_allclose(np.linalg.norm(queries - found.points, axis=1), found.distances, atol=1e-9)


def test_attachment_matrix_and_points_agree_and_follow_the_mesh():
    mesh = grid()
    held = Attachment(np.array([0, 7, 30]), RNG.dirichlet(np.ones(3), size=3))
    moved = mesh.with_vertices(mesh.vertices @ np.diag([2.0, 3, 1]) + 5)
    for m in (mesh, moved):
        np.testing.assert_allclose(held.matrix(mesh) @ m.vertices, held.points(m), atol=1e-12)
    found = closest_point(mesh, held.points(mesh)).attachment()
    np.testing.assert_allclose(found.points(mesh), held.points(mesh), atol=1e-9)


def test_barycentric_of_a_degenerate_triangle_is_thirds():
    a = np.zeros((1, 3))
    np.testing.assert_allclose(barycentric(np.ones((1, 3)), a, a, a), np.full((1, 3), 1 / 3))


def test_submesh_keeps_shape_and_tells_where_its_vertices_came_from():
    mesh = grid()
    part, old = submesh(mesh, np.array([3, 11, 12]))
    np.testing.assert_allclose(part.vertices, mesh.vertices[old])
    np.testing.assert_array_equal(old[part.faces], mesh.faces[[3, 11, 12]])


def test_wrong_shapes_are_refused():
    with pytest.raises(ValueError, match=r"vertex indices in 0\.\.2, got 0\.\.3"):
        Mesh(RIGHT.vertices, np.array([[0, 1, 3]]))
    with pytest.raises(ValueError, match=r"expected shape \(3, 3\)"):
        RIGHT.with_vertices(np.zeros((4, 3)))
