"""Sampling, Loop subdivision, transfer."""

import igl
import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from mien.errors import BadInput
from mien.mesh import Mesh, face_areas
from mien.mesh.sample import blue_noise, farthest_points, loop_subdivide, random_points, transfer


def _sphere(subdivisions=3, radius=10.0):
    ball = trimesh.creation.icosphere(subdivisions, radius)
    return Mesh(np.array(ball.vertices), np.array(ball.faces))


def test_farthest_points_on_a_line():
    line = np.arange(11.0)[:, None]
    np.testing.assert_array_equal(farthest_points(line, 3), [0, 10, 5])
    assert len(set(farthest_points(line, 11))) == 11
    with pytest.raises(BadInput, match="12 asked for of 11"):
        farthest_points(line, 12)


def test_random_points_follow_area():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 9]])
    mesh = Mesh(vertices, np.array([[0, 1, 2], [0, 1, 3]]))
    points = random_points(mesh, 20000)
    share = np.bincount(points.faces) / 20000
    np.testing.assert_allclose(share, face_areas(vertices, mesh.faces) / 5.0, atol=0.02)
    np.testing.assert_allclose(points.barycentric.mean(0), [1 / 3] * 3, atol=0.01)


def test_blue_noise_keeps_its_distance():
    mesh = _sphere()
    least = []
    for points in (blue_noise(mesh, 200), random_points(mesh, 200)):
        places = points.points(mesh)
        least.append(cKDTree(places).query(places, 2)[0][:, 1].min())
    assert least[0] > 0.6 * np.sqrt(4 * np.pi * 100 / 200)
    assert least[0] > 4 * least[1]


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
    mesh = _sphere(1)
    fine, _ = loop_subdivide(mesh)
    other, _ = igl.loop(mesh.vertices, mesh.faces.astype(np.int64), 1)
    distance, _ = cKDTree(other).query(fine.vertices)
    assert len(other) == len(fine.vertices)
    np.testing.assert_allclose(distance, 0, atol=1e-9)


def test_loop_is_affine_and_smooths():
    mesh = _sphere(1)
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
    np.testing.assert_allclose(areas.reshape(4, 2), np.tile(whole / 4, (4, 1)), atol=1e-12)


def test_transfer_of_a_linear_function():
    mesh = _sphere()
    points = random_points(mesh, 300).points(mesh)
    slope = np.array([[1.0, 0], [-2, 1], [3, 0.5]])
    np.testing.assert_allclose(transfer(mesh, mesh.vertices @ slope, points), points @ slope, atol=1e-9)
    np.testing.assert_allclose(transfer(mesh, mesh.vertices[:, 0], points), points[:, 0], atol=1e-9)
