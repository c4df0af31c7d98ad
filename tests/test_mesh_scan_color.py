"""Colour of scans on their vertices."""

import numpy as np

from mien.mesh import Mesh, Scan
from mien.mesh.scan_color import vertex_colours


def test_colours_come_from_the_texture_or_the_vertices():
    triangle = Mesh(np.eye(3), np.array([[0, 1, 2]]), uv=np.array([[0.1, 0.9], [0.9, 0.9], [0.1, 0.1]]))
    texture = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [9, 9, 9]]], np.uint8)
    np.testing.assert_allclose(vertex_colours(Scan(triangle, texture)), np.eye(3))
    plain = Mesh(np.eye(3), np.array([[0, 1, 2]]), colors=np.full((3, 3), 0.5))
    np.testing.assert_allclose(vertex_colours(Scan(plain)), 0.5)
    assert vertex_colours(Scan(Mesh(np.eye(3), np.array([[0, 1, 2]])))) is None
