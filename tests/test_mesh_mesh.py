"""Meshes and parts of them."""

import numpy as np
import pytest

from flat_meshes import RIGHT, grid
from mien.mesh import (
    Mesh,
    submesh,
)


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
