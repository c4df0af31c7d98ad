"""The lab turned to +Y up."""

import numpy as np

from mien.takes.world import turn_y_up
from mien.transforms import Transform, rotation_from_vector


def test_the_world_is_the_lab_turned_upright():
    for up in (np.array([np.pi / 2, 0, 0]), np.array([0, 0, -np.pi / 2]), np.array([np.pi, 0, 0]), np.zeros(3)):
        lean = rotation_from_vector(np.array([[0.1, 0.3, -0.1], [0.1, 0.4, 0.1]]))
        T = Transform(rotation_from_vector(up) @ lean, np.ones((2, 3)))
        world = turn_y_up(T)
        assert (world.rotation[:, 1, 1] > 0.9).all()
        turn = world.rotation @ np.swapaxes(T.rotation, 1, 2)
        np.testing.assert_allclose(turn, np.round(turn), atol=1e-12)
