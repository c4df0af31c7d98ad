"""Correspondences and the rigid step against their numpy twins."""

import numpy as np
import pytest

from kernel_scene import INTRINSICS, face_and_depth, matched
from mien._kernels import icp, icp_twin


@pytest.fixture(scope="module")
def scene():
    return face_and_depth()


def test_correspondences_agree(scene):
    _, _, points, normals, depth = scene
    fast = matched(scene)
    plain = icp_twin.correspond(points, normals, depth, INTRINSICS, 25.0, 0.3, 2)
    same = (fast[2] > 0) == (plain[2] > 0)
    assert same.mean() > 0.998
    assert (fast[2] > 0).sum() > 500
    for a, b, tolerance in zip(fast, plain, (2e-3, 2e-3, 1e-3), strict=True):
        np.testing.assert_allclose(a[same], b[same], atol=tolerance)


def test_rigid_system_agrees(scene):
    found, plane, weight = matched(scene)
    centre = np.array([0.0, 0.0, 600.0])
    fast = icp.rigid_system(scene[2], found, plane, weight, centre, 6.0)
    plain = icp_twin.rigid_system(scene[2], found, plane, weight, centre, 6.0)
    np.testing.assert_allclose(fast[0], plain[0], rtol=1e-4, atol=1e-3 * abs(plain[0]).max())
    np.testing.assert_allclose(fast[1], plain[1], atol=1e-3 * abs(plain[1]).max())
    assert fast[2] == pytest.approx(plain[2], rel=1e-4)
    assert fast[3] == plain[3]
