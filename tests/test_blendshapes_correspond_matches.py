"""Patches that are looked for far from where the rough warp puts them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from mien.blendshapes.correspond.matches import MatchConfig, best_shifts, matched_motion, smooth_motion
from mien.image_space.layout import grid_of, sampled

CONFIG = MatchConfig(pixel_mm=2.0, reach_mm=10.0)


def spots(seed: int = 0, shape=(60, 70)) -> np.ndarray:
    """Moles on a plain skin, two channels."""
    rng = np.random.default_rng(seed)
    image = gaussian_filter((rng.random((*shape, 2)) > 0.97).astype(float), (0.8, 0.8, 0))
    return image / image.std()


def test_a_shift_by_hand():
    first = spots()
    second = np.roll(first, (3, -2), axis=(0, 1))
    shift, sure = best_shifts(first, second, 5, 1.75)
    inside = np.s_[10:-10, 10:-10]
    np.testing.assert_allclose(np.median(shift[inside][sure[inside] > 0.5], axis=0), [-2, 3], atol=0.05)
    assert (sure[inside] > 0.5).mean() > 0.3


def test_plain_skin_says_nothing():
    _, sure = best_shifts(np.ones((30, 30, 1)), np.ones((30, 30, 1)), 3, 1.75)
    assert sure.max() == 0


def test_what_one_image_does_not_show_is_not_matched():
    first, second = spots(), spots()
    second[:, 35:] = np.nan
    _, sure = best_shifts(first, second, 4, 1.75)
    assert sure[:, 45:].max() == 0
    assert sure[:, 10:25].max() > 0.5


def test_a_motion_that_bends_smoothly_is_found():
    first = spots(1)
    grid = grid_of(first.shape)
    true = np.stack([3 * np.sin(grid[..., 1] / 20), 2 * np.cos(grid[..., 0] / 25)], -1)
    second = sampled(first, grid - true)
    found = matched_motion(first, second, CONFIG)
    inside = np.s_[8:-8, 8:-8]
    assert np.median(np.linalg.norm(found - true, axis=-1)[inside]) < 0.5


@pytest.mark.parametrize("slope", [0.0, 0.05])
def test_the_smooth_motion_keeps_a_level_and_a_slope_and_drops_one_wild_match(slope):
    grid = grid_of((20, 24))
    true = np.stack([2.0 + slope * grid[..., 0], -1.0 + 0 * grid[..., 1]], -1)
    sure = np.zeros((20, 24))
    sure[2::4, 2::4] = 1.0
    wild = true.copy()
    wild[10, 10] += 6.0
    found = smooth_motion(np.where(sure[..., None] > 0, wild, 0), sure, 30.0)
    assert np.abs(found - true)[4:-4, 4:-4].max() < 0.25


def test_what_is_held_does_not_move():
    first = spots()
    second = np.roll(first, 2, axis=1)
    steady = np.zeros(first.shape[:2])
    steady[30, 30] = 1e4
    found = matched_motion(first, second, replace(CONFIG, smooth=1.0), steady)
    assert np.linalg.norm(found[30, 30]) < 0.01
    assert np.linalg.norm(found[20, 12]) > 1.5
