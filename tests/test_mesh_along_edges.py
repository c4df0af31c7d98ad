"""Ways along edges, by hand."""

import numpy as np

from mien.mesh import Mesh, nearest_along_edges

STRIP = Mesh(
    np.array([[0.0, 0, 0], [3, 4, 0], [6, 0, 0], [9, 4, 0], [20, 0, 0], [21, 0, 0], [20, 1, 0]]),
    np.array([[0, 1, 2], [2, 1, 3], [4, 5, 6]]),
)
"""Two triangles in a row, with edges of 5 and 6, and one by itself."""


def test_the_nearest_of_some_vertices_along_the_edges_and_how_far():
    nearest, far = nearest_along_edges(STRIP, np.array([0, 3]))
    np.testing.assert_array_equal(nearest[[0, 2, 3]], [0, 3, 3])
    np.testing.assert_allclose(far[:4], [0, 5, 5, 0], atol=1e-6)


def test_where_no_way_leads_there_is_none():
    nearest, far = nearest_along_edges(STRIP, np.array([1]))
    assert (nearest[4:] < 0).all()
    assert np.isinf(far[4:]).all()


def test_an_edge_without_length_is_a_way():
    mesh = Mesh(np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0]]), np.array([[0, 1, 2]]))
    np.testing.assert_allclose(nearest_along_edges(mesh, np.array([0]))[1], [0, 0, 1], atol=1e-6)
