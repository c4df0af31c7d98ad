"""Ticks, numbers and scale bars."""

import numpy as np
import pytest

from mien.pictures import (
    scale_bar,
)
from mien.pictures.colormap import table
from mien.pictures.scale import nice_ticks, number


@pytest.mark.parametrize(("low", "high", "about", "ticks"), [
    (0.0, 1.0, 5, [0, 0.2, 0.4, 0.6, 0.8, 1]),
    (-1.3, 2.2, 5, [-1, -0.5, 0, 0.5, 1, 1.5, 2]),
    (0.0, 3.2e-3, 3, [0, 1e-3, 2e-3, 3e-3]),
    (97.0, 1260.0, 4, [250, 500, 750, 1000, 1250]),
    (2.0, 2.0, 4, [2]),
])  # fmt: skip
def test_ticks_are_round(low, high, about, ticks):
    np.testing.assert_allclose(nice_ticks(low, high, about), ticks, atol=1e-12)


def test_numbers_are_short():
    assert [number(x) for x in (0.30000000000000004, -0.0, 1250.0, -2.5, 1e-7)] == ["0.3", "0", "1250", "-2.5", "1e-07"]


@pytest.mark.parametrize("shape", [(40, 300), (300, 60)])
def test_scale_bar_runs_from_end_to_end(shape):
    height, width = shape
    bar = scale_bar(width, height, (0.0, 2.0), "mm")
    assert bar.shape == (*shape, 3)
    ends = (255 * table("heat")[[0, -2]] + 0.5).astype(np.uint8)
    found = [np.argwhere((bar == color).all(2)) for color in ends]
    axis = 1 if width > height else 0
    low, high = (places[:, axis].mean() for places in found)
    assert abs(high - low) > 0.6 * max(shape)
    assert (high > low) == (axis == 1)  # upright ones have the greatest value on top
    assert (bar.max(2) > 200).sum() > 20  # there are numbers on it
