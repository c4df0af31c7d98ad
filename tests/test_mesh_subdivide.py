"""Loop's subdivision."""

import igl
import numpy as np
import trimesh
from scipy.spatial import cKDTree

from mien.mesh import Mesh, face_areas, face_normals, loop_refinement, loop_subdivide, vertex_normals

SQUARE = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))


def sphere(subdivisions=3, radius=10.0):
    ball = trimesh.creation.icosphere(subdivisions, radius)
    return Mesh(np.array(ball.vertices), np.array(ball.faces))


def test_loop_weights_by_hand():
    """An inner edge's middle: 3/8 its ends, 1/8 the two opposite; a border edge's: 1/2; a border vertex: 3/4, 1/8."""
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    fine, S = loop_subdivide(mesh)
    rows = {tuple(row) for row in S.toarray()}
    assert (3 / 8, 1 / 8, 3 / 8, 1 / 8) in rows
    assert (1 / 2, 1 / 2, 0, 0) in rows
    np.testing.assert_allclose(S.toarray()[1], [1 / 8, 3 / 4, 1 / 8, 0])
    assert fine.faces.shape == (8, 3)


def test_loop_of_a_closed_mesh_agrees_with_libigl():
    mesh = sphere(1)
    fine, _ = loop_subdivide(mesh)
    other, _ = igl.loop(mesh.vertices, mesh.faces.astype(np.int64), 1)
    distance, _ = cKDTree(other).query(fine.vertices)
    assert len(other) == len(fine.vertices)
    np.testing.assert_allclose(distance, 0, atol=1e-9)


def test_loop_is_affine_and_smooths():
    mesh = sphere(1)
    fine, S = loop_subdivide(mesh, times=2)
    assert fine.faces.shape == (16 * len(mesh.faces), 3)
    np.testing.assert_allclose(S.sum(1), 1)
    np.testing.assert_allclose(S @ mesh.vertices, fine.vertices, atol=1e-12)
    moved = mesh.with_vertices(mesh.vertices @ np.diag([1.0, 2, 3]) + 5)
    np.testing.assert_allclose(
        loop_subdivide(moved, 2)[0].vertices, fine.vertices @ np.diag([1.0, 2, 3]) + 5, atol=1e-9
    )
    assert np.linalg.norm(fine.vertices, axis=1).std() < np.linalg.norm(mesh.vertices, axis=1).mean() * 0.02


def test_loop_keeps_texture_seams():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    uv = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5], [0.6, 0.6]])
    mesh = Mesh(vertices, np.array([[0, 1, 2], [0, 2, 3]]), uv, np.array([[0, 1, 2], [4, 5, 3]]))
    fine, _ = loop_subdivide(mesh)
    assert fine.uv is not None
    assert fine.uv_faces is not None
    assert fine.uv_faces.shape == fine.faces.shape
    flat = np.column_stack([fine.uv, np.zeros(len(fine.uv))])
    areas = face_areas(flat, fine.uv_faces)
    whole = face_areas(np.column_stack([uv, np.zeros(len(uv))]), mesh.uv_faces)
    np.testing.assert_allclose(areas.reshape(2, 4), np.tile(whole[:, None] / 4, 4), atol=1e-12)


def test_loop_subdivision_by_hand():
    """A tetrahedron: edge points 3/8 3/8 1/8 1/8, vertices 7/16 of themselves and 3/16 of each neighbour."""
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    finer = loop_refinement(faces, 4)
    matrix = finer.matrix.toarray()
    np.testing.assert_allclose(matrix[0], [7 / 16, 3 / 16, 3 / 16, 3 / 16])
    edge = finer.faces[0, 1]  # between 0 and 1
    np.testing.assert_allclose(matrix[edge], [3 / 8, 3 / 8, 1 / 8, 1 / 8])
    np.testing.assert_allclose(finer.between.toarray()[edge], [1 / 2, 1 / 2, 0, 0])
    assert finer.faces.shape == (16, 3)
    assert finer.matrix.shape == (10, 4)


def test_loop_subdivision_laws():
    """Rows add up to one, a plane stays a plane, open edges keep to their line, a ball gets rounder."""
    plane = SQUARE
    finer = loop_refinement(plane.faces, 4)
    np.testing.assert_allclose(np.asarray(finer.matrix.sum(1)), 1)
    np.testing.assert_allclose(np.asarray(finer.between.sum(1)), 1)
    corners = finer.corners(plane.vertices[plane.faces])
    np.testing.assert_allclose(corners, (finer.between @ plane.vertices)[finer.faces])
    np.testing.assert_allclose((finer.matrix @ plane.vertices)[:, 2], 0)
    coarse = sphere(1)
    smooth = loop_refinement(coarse.faces, len(coarse.vertices))
    moved = smooth.matrix @ coarse.vertices

    def facet_angle(vertices, faces):
        flat, round_ = face_normals(vertices, faces), vertex_normals(vertices, faces)
        return np.arccos(np.einsum("md,mcd->mc", flat, round_[faces])).max()

    assert facet_angle(moved, smooth.faces) < 0.6 * facet_angle(coarse.vertices, coarse.faces)
