"""Areas, normals and Laplacians."""

import numpy as np
import pytest

from flat_meshes import RIGHT, RNG, grid
from mien.mesh import (
    Mesh,
    adjacency,
    boundary_vertices,
    connected_parts,
    cotangent_laplacian,
    edge_ends,
    face_areas,
    face_normals,
    grid_faces,
    in_largest_part,
    mass,
    mean_edge_length,
    uniform_laplacian,
    vertex_normals,
)


def test_edges_and_parts_by_hand():
    """Two triangles that share an edge, one by itself, and a vertex of none."""
    faces = np.array([[0, 1, 2], [2, 1, 3], [6, 5, 4]])
    ends = [[0, 1], [1, 2], [0, 2], [1, 2], [1, 3], [2, 3], [5, 6], [4, 5], [4, 6]]
    np.testing.assert_array_equal(edge_ends(faces), ends)
    np.testing.assert_array_equal(connected_parts(faces, 8), [0, 0, 0, 0, 1, 1, 1, 2])


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


def test_a_grid_of_points_becomes_triangles_but_not_across_holes_and_steps():
    y, x = np.mgrid[:2, :4].astype(float)
    points = np.stack([x, y, 0 * x], -1)
    np.testing.assert_array_equal(grid_faces(points[:, :2], 2.0), [[0, 2, 1], [1, 2, 3]])
    points[:, 3, 2] = 9.0
    assert (grid_faces(points, 2.0) % 4 < 3).all()
    points[0, 0] = np.nan
    np.testing.assert_array_equal(np.sort(grid_faces(points, 2.0), axis=1), [[1, 2, 5], [1, 4, 5], [2, 5, 6]])


def test_the_connected_part_of_the_most_triangles():
    faces = np.array([[0, 1, 2], [3, 4, 5], [4, 6, 5]])
    np.testing.assert_array_equal(in_largest_part(faces, 8), [False, True, True])
