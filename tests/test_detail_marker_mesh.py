import numpy as np
import pytest

from detail_patch import marker_places, patch
from mien.detail.marker_mesh import interpolation, marker_mesh
from mien.errors import BadInput
from mien.mesh import Attachment, Mesh, closest_point


def test_a_grid_of_markers_is_triangulated_whole():
    """By Euler: a disc over v vertices, b of them on its rim, has 2 v - 2 - b triangles."""
    mesh = patch()
    coarse = marker_mesh(mesh, marker_places(mesh))
    assert len(coarse.triangles) == pytest.approx(2 * 25 - 2 - 16, abs=2)
    points = marker_places(mesh).points(mesh)
    a, b, c = (points[coarse.triangles[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_nothing_bridges_a_slit():
    """A mouth: the patch cut along y = 0 for most of its width; markers above and below it."""
    mesh = patch()
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    cut = (np.abs(middle[:, 1]) < 2.5) & (np.abs(middle[:, 0]) < 22)
    slit = Mesh(mesh.vertices, mesh.faces[~cut], uv=mesh.uv)
    at = closest_point(slit, np.array([[x, y, 12.0] for y in (-12, -6, 6, 12) for x in (-18, -6, 6, 18)])).attachment()
    coarse = marker_mesh(slit, at)
    side = at.points(slit)[:, 1] > 0
    inner = np.abs(at.points(slit)[:, 0]) < 10
    for triangle in coarse.triangles:
        if inner[triangle].sum() >= 2:
            assert len(set(side[triangle])) == 1


def test_linear_values_are_interpolated_exactly_inside():
    mesh = patch()
    at = marker_places(mesh)
    coarse = marker_mesh(mesh, at)
    inside = closest_point(mesh, np.array([[x, y, 12.0] for x in (-9, 0, 9) for y in (-9, 0, 9)])).attachment()
    found = interpolation(coarse, mesh, at, inside)

    def flat(points):
        return np.einsum("pc,pcd->pd", points.barycentric, mesh.uv[mesh.faces[points.faces]])

    np.testing.assert_allclose(found.of(flat(at)), flat(inside), atol=1e-9)
    np.testing.assert_allclose(found.weights.sum(axis=1), 1)


def test_beyond_the_rim_values_stay_within_range():
    mesh = patch()
    at = marker_places(mesh)
    corners = closest_point(mesh, mesh.vertices[[0, 32, -33, -1]]).attachment()
    found = interpolation(marker_mesh(mesh, at), mesh, at, corners)
    assert (found.weights >= 0).all()
    np.testing.assert_allclose(found.weights.sum(axis=1), 1)


def test_too_few_markers_are_refused_and_a_lonely_one_is_left_out():
    mesh = patch(9)
    with pytest.raises(BadInput, match="at least 3"):
        marker_mesh(mesh, Attachment(np.array([0, 1]), np.full((2, 3), 1 / 3)))
    island = Mesh(
        np.concatenate([mesh.vertices, [[100, 0, 0], [110, 0, 0], [100, 10, 0]]]),
        np.concatenate([mesh.faces, [[81, 82, 83]]]),
    )
    at = Attachment(np.array([3, 40, 100, len(mesh.faces)]), np.full((4, 3), 1 / 3))
    coarse = marker_mesh(island, at)
    assert set(coarse.triangles.ravel()) == {0, 1, 2}
    assert set(coarse.nearest[:81]) == {0, 1, 2}
