"""Polygons to triangles, corners to vertices."""

import numpy as np

from mien.io.meshes.polygons import fan, weld


def test_fan_by_hand():
    np.testing.assert_array_equal(fan(np.array([3, 4, 2, 5])), [
        [0, 1, 2], [3, 4, 5], [3, 5, 6], [9, 10, 11], [9, 11, 12], [9, 12, 13],
    ])  # fmt: skip


def test_weld_keeps_first_met_order():
    rows = np.array([[2.0, 0], [1, 1], [2, -0.0], [0, 0], [1, 1]])
    np.testing.assert_array_equal(weld(rows), [0, 1, 0, 2, 1])
