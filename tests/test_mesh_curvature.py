"""Mean curvature of surfaces where it is known."""

import numpy as np
import pytest
import scipy.spatial.transform as st
import trimesh

from curved_meshes import height_field
from mien.errors import BadInput
from mien.mesh import Mesh
from mien.mesh.curvature import curvature_features, mean_curvature


def _sphere(radius, subdivisions=4):
    ball = trimesh.creation.icosphere(subdivisions, radius)
    return Mesh(np.array(ball.vertices), np.array(ball.faces))


def _inner(mesh, margin=4.0):
    return np.abs(mesh.vertices[:, :2]).max(1) < np.abs(mesh.vertices[:, :2]).max() - margin


@pytest.mark.parametrize("radius", [10.0, 50.0])
def test_sphere(radius):
    found = mean_curvature(_sphere(radius), radius=0.2 * radius)
    np.testing.assert_allclose(found, 1 / radius, rtol=0.02)


def test_cylinder_plane_saddle():
    r = 30.0
    cylinder = height_field(lambda x, y: np.sqrt(r * r - x * x))
    np.testing.assert_allclose(mean_curvature(cylinder, 3.0)[_inner(cylinder)], 1 / (2 * r), rtol=0.03)
    plane = height_field(lambda x, y: 0.3 * x + 0.1 * y)
    np.testing.assert_allclose(mean_curvature(plane, 3.0), 0, atol=1e-9)
    saddle = height_field(lambda x, y: x * y / 40)
    middle = np.abs(saddle.vertices[:, :2]).max(1) < 0.5
    np.testing.assert_allclose(mean_curvature(saddle, 3.0)[middle], 0, atol=1e-9)


def test_creases_are_negative():
    groove = height_field(lambda x, y: -np.exp(-x * x / 8))
    middle = (np.abs(groove.vertices[:, 0]) < 0.5) & _inner(groove)
    assert (mean_curvature(groove, 2.5)[middle] < -0.05).all()


def test_rigid_motion_changes_nothing_and_scale_divides():
    bumpy = height_field(lambda x, y: np.sin(0.3 * x) * np.cos(0.2 * y))
    turned = st.Rotation.from_euler("xyz", [0.4, 1.1, -2.0]).apply(bumpy.vertices) + np.array([5.0, -3.0, 100.0])
    found = mean_curvature(bumpy, 2.5)
    np.testing.assert_allclose(mean_curvature(bumpy.with_vertices(turned), 2.5), found, atol=1e-9)
    np.testing.assert_allclose(mean_curvature(bumpy.with_vertices(2 * bumpy.vertices), 5.0), found / 2, atol=1e-9)


def test_the_other_side_of_a_gap_does_not_count():
    """Two sheets half a millimetre apart, bent opposite ways, joined nowhere: each keeps its own curvature."""
    up = height_field(lambda x, y: (x * x + y * y) / 60)
    n = len(up.vertices)
    down = up.vertices * np.array([1, 1, -1]) - np.array([0, 0, 0.5])
    both = Mesh(np.concatenate([up.vertices, down]), np.concatenate([up.faces, up.faces + n]))
    np.testing.assert_allclose(mean_curvature(both, 3.0)[:n], mean_curvature(up, 3.0), atol=1e-12)


def test_coarse_meshes_take_more_rings():
    """A ball smaller than the edges still gets a fit."""
    np.testing.assert_allclose(mean_curvature(_sphere(10.0, 3), radius=0.1), 0.1, rtol=0.05)


def test_lone_vertices_are_flat():
    ball = _sphere(10.0, 2)
    mesh = Mesh(np.concatenate([ball.vertices, [[99.0, 0, 0]]]), ball.faces)
    assert mean_curvature(mesh, 5.0)[-1] == 0


def test_features():
    values = np.array([-0.2, -0.04, 0.0, 0.04, 0.06])
    np.testing.assert_array_equal(curvature_features(values), [-0.2, 0, 0, 0, 0.06])
    np.testing.assert_array_equal(curvature_features(values, signed=False), [0, 0, 0, 0, 0.06])
    np.testing.assert_array_equal(curvature_features(values, threshold=0.1), [-0.2, 0, 0, 0, 0])


def test_bad_radius_is_named():
    with pytest.raises(BadInput, match="radius is 0"):
        mean_curvature(_sphere(10.0, 1), 0.0)
