"""Drawing into the image and coming back."""

import numpy as np
import pytest

from mien._kernels import raster as kernels
from mien._kernels import raster_twin as twins
from mien.errors import BadInput
from mien.mesh.raster import SurfaceImage

SQUARE = np.array([[1.0, 1.0], [6.0, 1.0], [6.0, 4.0], [1.0, 4.0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def _net(rng, count=9, spread=0.3):
    """A jittered grid that covers 20 x 20 pixels, triangles all turned the same way."""
    x, y = np.meshgrid(np.linspace(2, 17, count), np.linspace(2, 17, count))
    places = np.stack([x, y], -1).reshape(-1, 2) + spread * rng.standard_normal((count * count, 2))
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel()
    return places, np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


def test_square_by_hand():
    image = SurfaceImage(SQUARE, TWO, (6, 8))
    expected = np.zeros((6, 8), bool)
    expected[1:5, 1:7] = True
    np.testing.assert_array_equal(image.mask, expected)
    assert image.faces[1, 6] == 0
    assert image.faces[4, 1] == 1
    drawn = image.draw(SQUARE)
    y, x = np.mgrid[:6, :8]
    np.testing.assert_allclose(drawn[image.mask], np.stack([x, y], -1)[image.mask], atol=1e-12)
    assert np.isnan(drawn[~image.mask]).all()


def test_no_cracks_and_linear_functions_are_exact():
    places, faces = _net(np.random.default_rng(0))
    image = SurfaceImage(places, faces, (20, 20))
    assert image.mask[4:15, 4:15].all()
    drawn = image.draw(2 * places[:, 0] - places[:, 1] + 3)
    y, x = np.mgrid[:20, :20]
    np.testing.assert_allclose(drawn[image.mask], (2 * x - y + 3)[image.mask], atol=1e-9)
    np.testing.assert_allclose(image.barycentric[image.mask].sum(-1), 1)


def test_kernel_and_twin_agree():
    places, faces = _net(np.random.default_rng(1))
    faces[3] = faces[3, ::-1]
    places[0] = places[1]
    results = []
    for module in (kernels, twins):
        owner, bary = np.full((20, 20), -1, np.int64), np.zeros((20, 20, 3))
        module.scan_convert(places, faces, owner, bary)
        results.append((owner, bary))
    np.testing.assert_array_equal(results[0][0], results[1][0])
    np.testing.assert_allclose(results[0][1], results[1][1], atol=1e-9)


def test_image_points_come_back_to_where_they_are():
    rng = np.random.default_rng(2)
    places, faces = _net(rng)
    image = SurfaceImage(places, faces, (20, 20))
    points = rng.uniform(4, 15, (200, 2))
    back = image.surface_at(points)
    np.testing.assert_allclose(np.einsum("pc,pcd->pd", back.barycentric, places[faces[back.faces]]), points, atol=1e-9)


def test_points_off_the_surface_go_to_its_border():
    image = SurfaceImage(SQUARE, TWO, (6, 8))
    back = image.surface_at(np.array([[-3.0, 2.0], [9.0, 9.0]]))
    np.testing.assert_allclose(back.barycentric.sum(1), 1)
    found = np.einsum("pc,pcd->pd", back.barycentric, SQUARE[TWO[back.faces]])
    np.testing.assert_allclose(found, [[1, 2], [6, 4]], atol=1e-12)


def test_bad_places_are_named():
    with pytest.raises(BadInput, match="must be finite"):
        SurfaceImage(np.full((4, 2), np.nan), TWO, (4, 4))
    with pytest.raises(BadInput, match="3 places"):
        SurfaceImage(SQUARE[:3], TWO, (4, 4))
