"""Closest points and attachments."""

import numpy as np

from flat_meshes import RIGHT, RNG, grid
from mien.mesh import (
    Attachment,
    ClosestPoint,
    Mesh,
    barycentric,
    closest_point,
)


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
