"""Affine triangles between landmarks."""

import numpy as np
import pytest

from mien.blendshapes.correspond.prewarp import prewarp
from mien.errors import BadInput

POINTS = np.array([[10, 10], [40, 12], [38, 40], [12, 38], [25, 25]], float)


def test_landmarks_go_where_they_should_and_triangles_are_affine():
    there = POINTS + np.array([[2, 1], [2, 1], [2, 1], [2, 1], [5, 4]])
    flow = prewarp(POINTS, there, (60, 60))
    np.testing.assert_allclose(flow[25, 25], [5, 4])
    np.testing.assert_allclose(flow[10, 10], [2, 1])
    np.testing.assert_allclose(flow[18, 25], (flow[17, 25] + flow[19, 25]) / 2, atol=1e-9)


def test_the_maps_rim_stays():
    flow = prewarp(POINTS, POINTS + 5, (60, 60))
    assert np.abs(flow[[0, -1]]).max() < 1
    assert np.isfinite(flow).all()


def test_too_few_landmarks_are_refused():
    with pytest.raises(BadInput, match="three at least"):
        prewarp(POINTS[:2], POINTS[:2], (60, 60))
