"""Colour maps and their limits."""

from dataclasses import replace

import numpy as np
import pytest

from lit_things import CAMERA, FACING, FLAT, square
from mien.pictures import colors_of, render
from mien.pictures.color import to_linear
from mien.pictures.colormap import MAPS, NOTHING, own_limits, table


def test_heat_map_colours_at_the_limits():
    values = np.array([0.0, 2.0, 2.0, 0.0])  # runs from left to right
    image = render(square(), CAMERA, FACING, replace(FLAT, limits=(0.5, 1.5)), values=values)
    low, high = (np.rint(255 * table("heat")[level]).astype(int) for level in (0, -2))
    np.testing.assert_allclose(image[16, 7], low, atol=1)
    np.testing.assert_allclose(image[16, 24], high, atol=1)
    middle = (image[16, 15].astype(float) + image[16, 16]) / 2
    np.testing.assert_allclose(middle, 255 * colors_of(np.array([1.0]), (0.5, 1.5))[0], atol=4)


def test_values_that_are_nan_are_grey_and_their_own_range_is_the_default():
    values = np.array([1.0, 3.0, 3.0, np.nan])
    image = render(square(), CAMERA, FACING, FLAT, values=values)
    np.testing.assert_allclose(image[8, 8], 255 * np.array(NOTHING), atol=1)  # upper left
    right = colors_of(np.array([1 + 2 * (17 + 20) / 40]), (1.0, 3.0))[0]  # x = 17 mm of -20..20
    np.testing.assert_allclose(image[24, 24], 255 * right, atol=1)
    assert own_limits(values) == (1.0, 3.0)
    assert own_limits(np.full(3, 2.0)) == (2.0, 3.0)
    assert own_limits(np.full(3, np.nan)) == (0.0, 1.0)


@pytest.mark.parametrize("name", MAPS)
def test_colour_maps_are_even_to_the_eye(name):
    """Lightness (CIE L*) runs steadily; a diverging map is as light on both sides."""
    colors = table(name)[:-1]
    assert colors.min() >= 0
    assert colors.max() <= 1
    Y = to_linear(colors) @ [0.2126, 0.7152, 0.0722]
    L = 116 * np.cbrt(Y) - 16
    half = len(L) if name == "heat" else len(L) // 2
    steps = np.diff(L[:half:16])
    assert (steps > 0).all()
    assert steps.max() < 2.2 * steps.min()
    if name == "diverging":
        np.testing.assert_allclose(L, L[::-1], atol=4)
