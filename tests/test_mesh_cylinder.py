"""Unrolling from a cylinder, with and without folds."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.mesh import Mesh
from mien.mesh.cylinder import Cylinder, _distortion, _surface_gradients, fit_cylinder, unroll_face


def _shell(bump=None, count=41, radius=80.0, height=160.0, arc=2.4):
    """A piece of cylinder, open at the back; `bump(angle, y)` gives (outwards, upwards) displacements in mm."""
    angle, y = np.meshgrid(np.linspace(-arc / 2, arc / 2, count), np.linspace(-height / 2, height / 2, count))
    out, up = bump(angle, y) if bump else (0.0, 0.0)
    x, z = (radius + out) * np.sin(angle) + 5.0, (radius + out) * np.cos(angle) - 60.0
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return Mesh(np.stack([x, y + up, z], -1).reshape(-1, 3), faces)


def _nose(angle, y):
    """A knob that droops, so that its underside turns over when projected."""
    knob = np.exp(-((angle * 80 / 12) ** 2) - (y / 12) ** 2)
    return 18 * knob, -22 * knob


def _signed_areas(uv, faces):
    a, b, c = (uv[faces[:, i]] for i in range(3))
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


def test_cylinder_is_found():
    found = fit_cylinder(_shell())
    np.testing.assert_allclose([found.x, found.z, found.radius], [5.0, -60.0, 80.0], atol=0.2)


def test_the_axis_goes_behind_all_of_the_face():
    """A shelf under the chin reaches behind the axis that fits the rest."""
    shell = _shell(count=21)
    shelf = np.array([[-10.0, -85, 0], [20, -85, 0], [5, -85, -75]])
    mesh = Mesh(np.concatenate([shell.vertices, shelf]), np.concatenate([shell.faces, [[441, 442, 443]]]))
    found = fit_cylinder(mesh)
    assert found.z < -74
    assert np.abs(found.unroll(mesh.vertices)[:, 0]).max() < 2.0 * found.radius


def test_a_cylinder_unrolls_without_distortion():
    cylinder = Cylinder(5.0, -60.0, 80.0)
    flat = unroll_face(_shell(), pixel_mm=0.5, cylinder=cylinder)
    assert (flat.folded, flat.squeezed, flat.moved) == (0, 0, 0)
    np.testing.assert_allclose(np.ptp(flat.uv, axis=0) * 0.5, [80 * 2.4, 160], atol=1e-9)
    assert flat.shape == (325, 389)
    right_top = flat.uv.reshape(41, 41, 2)[-1, -1]
    np.testing.assert_allclose(right_top, [2 + 192 / 0.5, 2], atol=1e-9)


def test_image_shows_left_on_the_right_and_up_above():
    mesh = _shell()
    image = unroll_face(mesh, pixel_mm=2.0).image()
    drawn = image.draw(mesh.vertices)
    middle = drawn.shape[0] // 2, drawn.shape[1] // 2
    assert drawn[middle[0], -8, 0] > drawn[middle[0], 8, 0]
    assert drawn[8, middle[1], 1] > drawn[-8, middle[1], 1]
    assert np.isfinite(drawn[4:-4, 4:-4]).all()


def test_folds_are_undone_where_they_are():
    mesh = _shell(_nose)
    cylinder = Cylinder(5.0, -60.0, 80.0)
    flat = unroll_face(mesh, cylinder=cylinder)
    assert flat.folded > 10
    areas = _signed_areas(flat.uv * [1, -1], mesh.faces)
    assert (areas > 0).all()
    plain = cylinder.unroll(mesh.vertices) / 0.5
    far = np.hypot(mesh.vertices[:, 0] - 5.0, mesh.vertices[:, 1]) > 65
    shift = flat.uv * [1, -1] - plain
    np.testing.assert_allclose(shift[far] - shift[far][0], 0, atol=1e-6)
    assert 0 < flat.moved < 0.6 * len(mesh.vertices)


def test_the_map_is_one_to_one():
    """Every vertex is found again at its own place, and triangles' areas add up to that of the image."""
    mesh = _shell(_nose)
    flat = unroll_face(mesh)
    image = flat.image()
    back = image.surface_at(flat.uv).points(mesh)
    np.testing.assert_allclose(back, mesh.vertices, atol=1e-6)
    areas = np.abs(_signed_areas(flat.uv, mesh.faces)).sum()
    np.testing.assert_allclose(image.mask.sum(), areas, rtol=0.01)
    assert flat.overlap < 0.01


def test_layers_are_told():
    sheet = _shell(count=21)
    both = Mesh(
        np.concatenate([sheet.vertices, 0.9 * sheet.vertices]), np.concatenate([sheet.faces, sheet.faces + 441])
    )
    assert unroll_face(both, cylinder=Cylinder(5.0, -60.0, 80.0)).overlap > 0.3


def test_distortion_is_least_for_rigid_maps_and_its_gradient_is_right():
    rng = np.random.default_rng(0)
    vertices, faces = rng.standard_normal((5, 3)), np.array([[0, 1, 2], [1, 3, 2], [2, 3, 4]])
    gradients, areas = _surface_gradients(vertices, faces)
    plane = np.column_stack([rng.standard_normal((5, 2)), np.zeros(5)])
    own, size = _surface_gradients(plane, faces[:1])
    c, s = np.cos(0.7), np.sin(0.7)
    turned = plane[:, :2] @ np.array([[c, s], [-s, c]])
    if np.linalg.det(plane[faces[0]][1:, :2] - plane[faces[0]][0, :2]) < 0:
        turned = turned[:, ::-1]
    value, slope = _distortion(turned, faces[:1], own, size, 1e-9)
    np.testing.assert_allclose(value, 4 * size[0], rtol=1e-6)
    np.testing.assert_allclose(slope, 0, atol=1e-6)
    uv, direction = rng.standard_normal((2, 5, 2))
    step = 1e-6
    ends = [_distortion(uv + t * direction, faces, gradients, areas, 0.3)[0] for t in (step, -step)]
    slope = _distortion(uv, faces, gradients, areas, 0.3)[1]
    np.testing.assert_allclose((ends[0] - ends[1]) / (2 * step), (slope * direction).sum(), rtol=1e-5)


def test_bad_meshes_are_named():
    with pytest.raises(BadInput, match="all round"):
        unroll_face(_shell(arc=6.6), cylinder=Cylinder(5.0, -60.0, 80.0))
    with pytest.raises(BadInput, match="pixel_mm is 0"):
        unroll_face(_shell(), pixel_mm=0.0)
