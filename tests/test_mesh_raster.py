"""Drawing into the image and coming back."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.mesh.raster import SurfaceImage
from nets import net

SQUARE = np.array([[1.0, 1.0], [6.0, 1.0], [6.0, 4.0], [1.0, 4.0]])


TWO = np.array([[0, 1, 2], [0, 2, 3]])


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
    places, faces = net(np.random.default_rng(0))
    image = SurfaceImage(places, faces, (20, 20))
    assert image.mask[4:15, 4:15].all()
    drawn = image.draw(2 * places[:, 0] - places[:, 1] + 3)
    y, x = np.mgrid[:20, :20]
    np.testing.assert_allclose(drawn[image.mask], (2 * x - y + 3)[image.mask], atol=1e-9)
    np.testing.assert_allclose(image.barycentric[image.mask].sum(-1), 1)


def test_image_points_come_back_to_where_they_are():
    rng = np.random.default_rng(2)
    places, faces = net(rng)
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
