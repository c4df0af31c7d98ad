"""Which points belong together."""

import numpy as np

from hilly_meshes import hills
from mien.mesh import vertex_normals
from mien.register import (
    Surface,
)


def test_correspondences_of_some_among_all():
    target = hills(9)
    some = np.array([3, 7])
    found = Surface(target).correspond(target.vertices[some] + 0.1, vertex_normals(target.vertices, target.faces)[some])
    among = found.among(10, some)
    np.testing.assert_array_equal(among.points[some], found.points)
    np.testing.assert_array_equal(np.flatnonzero(among.accepted), some[found.accepted])
    assert among.points.shape == (10, 3)
    assert not among.normals[np.setdiff1d(np.arange(10), some)].any()
