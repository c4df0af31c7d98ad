"""A face as an image on the cylinder."""

import numpy as np
import pytest

from mien.blendshapes.cylinder_map import CylinderLayout, map_of_scan, mesh_of_map
from mien.errors import BadInput
from mien.faces import load_face
from mien.mesh import Mesh, Scan, closest_point, face_normals

LAYOUT = CylinderLayout(2.0)


def tube(radius: float) -> Mesh:
    """A half tube round the axis, its normals outwards."""
    angle, height = np.meshgrid(np.linspace(-1.5, 1.5, 61), np.linspace(60, -60, 41))
    points = np.stack([radius * np.sin(angle), height, radius * np.cos(angle)], -1).reshape(-1, 3)
    index = np.arange(angle.size).reshape(angle.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]))
    uv = np.stack([angle.ravel() / 3 + 0.5, height.ravel() / 120 + 0.5], 1)
    return Mesh(points, np.concatenate([np.stack([a, b, c], 1), np.stack([c, b, d], 1)]), uv)


def test_points_of_pixels_lie_at_those_pixels():
    h, w = LAYOUT.shape
    there = LAYOUT.pixels(LAYOUT.points(np.full((h, w), 77.0)))
    rows, columns = np.mgrid[:h, :w]
    np.testing.assert_allclose(there, np.stack([columns, rows], -1), atol=1e-9)


def test_left_is_right_and_up_is_up():
    middle, left, up = LAYOUT.pixels(np.array([[0, 0, 90.0], [10, 0, 90.0], [0, 10, 90.0]]))
    assert left[0] > middle[0]
    assert up[1] < middle[1]


def test_a_layout_is_known_by_its_shape():
    for pixel in (0.4, 0.5, 1.0, 2.0):
        assert CylinderLayout.of_shape(*CylinderLayout(pixel).shape).shape == CylinderLayout(pixel).shape
    with pytest.raises(BadInput, match="none of ours"):
        CylinderLayout.of_shape(512, 512)


def test_of_surfaces_one_behind_the_other_the_outermost_is_laid_out():
    inner, outer = tube(60), tube(100)
    faces = np.concatenate([inner.faces, outer.faces + len(inner.vertices)])
    both = Mesh(np.concatenate([inner.vertices, outer.vertices]), faces)
    radii = np.hypot(*np.moveaxis(map_of_scan(Scan(both), LAYOUT).positions[..., [0, 2]], -1, 0))
    np.testing.assert_allclose(radii[np.isfinite(radii)], 100, atol=0.1)


def test_a_texture_comes_along():
    ramp = np.zeros((8, 64, 3), np.uint8)
    ramp[..., 0] = np.linspace(0, 255, 64)
    map_ = map_of_scan(Scan(tube(90), ramp), LAYOUT)
    red = map_.colors[LAYOUT.shape[0] // 2, :, 0]
    known = np.flatnonzero(np.isfinite(red))
    assert np.corrcoef(known, red[known])[0, 1] > 0.999
    assert red[known[-1]] > red[known[0]]


def test_the_maps_mesh_is_the_face_again_and_faces_outwards():
    neutral = load_face().rig.neutral
    scan = mesh_of_map(map_of_scan(Scan(neutral), LAYOUT))
    assert closest_point(neutral, scan.mesh.vertices).distances.max() < 1e-3
    out = face_normals(scan.mesh.vertices, scan.mesh.faces)
    middle = scan.mesh.vertices[scan.mesh.faces].mean(1) * [1, 0, 1]
    assert ((out * middle).sum(1) > 0).mean() > 0.99


def test_values_beside_a_hole_and_outside_are_nan():
    map_ = map_of_scan(Scan(tube(90)), LAYOUT)
    positions, colors = map_.at(np.array([[-5.0, 10.0], [80.0, 60.0]]))
    assert np.isnan(positions[0]).all()
    assert np.isfinite(positions[1]).all()
    assert np.isfinite(colors[1]).all()


def test_a_mesh_that_shows_only_its_back_is_refused():
    back = Mesh(tube(90).vertices, tube(90).faces[:, ::-1].copy())
    with pytest.raises(BadInput, match="is it a face"):
        map_of_scan(Scan(back), LAYOUT)
