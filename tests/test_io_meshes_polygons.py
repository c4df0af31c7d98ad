"""Polygons to triangles, corners to vertices."""

import numpy as np

from mien.io.meshes.polygons import fan, strip_triangles, weld


def test_fan_by_hand():
    np.testing.assert_array_equal(fan(np.array([3, 4, 2, 5])), [
        [0, 1, 2], [3, 4, 5], [3, 5, 6], [9, 10, 11], [9, 11, 12], [9, 12, 13],
    ])  # fmt: skip


def test_weld_keeps_first_met_order():
    rows = np.array([[2.0, 0], [1, 1], [2, -0.0], [0, 0], [1, 1]])
    np.testing.assert_array_equal(weld(rows), [0, 1, 0, 2, 1])


def test_strips_by_hand():
    """Two strips in the first row, one in the second; a repeated vertex makes no triangle."""
    items = np.array([0, 1, 2, 3, -1, 4, 5, 6, 7, 7, 8, 9])
    found = strip_triangles(items, np.array([8, 4]))
    np.testing.assert_array_equal(found, [[0, 1, 2], [2, 1, 3], [4, 5, 6], [8, 7, 9]])
