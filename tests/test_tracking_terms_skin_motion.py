"""Skin that has moved loses its say in the head's pose, and gets it back when it is long still."""

import numpy as np

from mien.tracking.terms.skin_motion import MEMORY, STILL_MM, learn_motion, no_motion

NORMALS = np.tile(np.array([0, 0, 1], np.float32), (3, 1))
SHARE = np.array([0.5, 0.25, 0.25], np.float32)


def test_nothing_seen_counts_by_area():
    np.testing.assert_allclose(no_motion(NORMALS).pose_weights(SHARE), SHARE)


def test_motion_along_the_normal_halves_the_say_and_motion_along_the_skin_does_not():
    motion = no_motion(NORMALS)
    for _ in range(5):
        motion = learn_motion(motion, np.array([[0, 0, STILL_MM], [2, 1, 0], [0, 0, 0]], np.float32))
    np.testing.assert_allclose(motion.pose_weights(SHARE), [1 / 3, 1 / 3, 1 / 3], rtol=1e-5)


def test_what_was_long_ago_is_forgotten():
    motion = learn_motion(no_motion(NORMALS), np.array([[0, 0, 9], [0, 0, 0], [0, 0, 0]], np.float32))
    for _ in range(round(12 * MEMORY)):
        motion = learn_motion(motion, np.zeros((3, 3), np.float32))
    np.testing.assert_allclose(motion.pose_weights(SHARE), SHARE, rtol=1e-3)
