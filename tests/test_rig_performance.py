"""A rig in motion: its meshes, and what does not fit together."""

from dataclasses import replace

import numpy as np
import pytest

from mien.mesh import Mesh
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector

RIG = Rig(Mesh(np.eye(3), np.array([[0, 1, 2]])), np.full((1, 3, 3), 2.0), ("up",))
TURN = rotation_from_vector(np.array([[0.0, 0, 0], [0, np.pi / 2, 0]]))
PLAY = Performance(
    RIG, np.array([[0.0], [0.5]]), Transform(TURN, np.array([[0.0, 0, 0], [7, 0, 0]])), 50.0, np.array([True, False])
)


def test_meshes_in_face_space_and_in_the_world():
    first, second = PLAY.meshes()
    np.testing.assert_array_equal(first.vertices, np.eye(3))
    np.testing.assert_array_equal(second.vertices, np.eye(3) + 1)
    *_, placed = PLAY.meshes(world=True)
    x, y, z = second.vertices.T
    np.testing.assert_allclose(placed.vertices, np.stack([z + 7, y, -x], 1), atol=1e-12)


def test_it_prints_as_one_line():
    assert len(PLAY) == 2
    assert "2 frames at 50 a second (0.0 s)" in repr(PLAY)
    assert "1 tracked" in repr(PLAY)


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="expected 1 a frame"):
        replace(PLAY, weights=np.zeros((2, 3)))
