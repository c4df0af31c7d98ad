"""Sampling, transfer."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from mien.errors import BadInput
from mien.mesh import Mesh, face_areas
from mien.mesh.sample import blue_noise, farthest_points, random_points, transfer


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


def test_transfer_of_a_linear_function():
    mesh = _sphere()
    points = random_points(mesh, 300).points(mesh)
    slope = np.array([[1.0, 0], [-2, 1], [3, 0.5]])
    np.testing.assert_allclose(transfer(mesh, mesh.vertices @ slope, points), points @ slope, atol=1e-9)
    np.testing.assert_allclose(transfer(mesh, mesh.vertices[:, 0], points), points[:, 0], atol=1e-9)
