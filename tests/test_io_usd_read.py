"""Faces of other programs: units, axes, winding, polygons, sparse shapes, what is left out."""

import numpy as np

from mien.io import usd
from usd_files import foreign


def test_a_rig_of_another_program(tmp_path):
    heard = []
    found = usd.read_rig(foreign(tmp_path / "a.usda"), heard.append)
    np.testing.assert_allclose(found.neutral.vertices, [[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]], atol=1e-6)
    a, b, c = found.neutral.vertices[found.neutral.faces[0]]
    assert np.cross(b - a, c - a)[2] < 0  # left-handed in the file: it faces the other way
    np.testing.assert_allclose(found.deltas[0], [[0, 0, 0], [0, 0, 0], [0, 10, 0], [0, 0, 0]], atol=1e-6)
    assert found.names == ("smile", "frown", "unused")
    assert (found.deltas[2] == 0).all()
    corners = found.neutral.uv[found.neutral.uv_faces]
    np.testing.assert_allclose(corners, found.neutral.vertices[found.neutral.faces][..., :2] / 10)
    assert len(heard) == 1
    assert "inbetweens are left out" in heard[0]
