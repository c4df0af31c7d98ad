"""Buckling and furrows by hand, and wrinkles where faces have them."""

import numpy as np
import pytest

from mien.stage.people.wrinkles import buckling, furrows


def test_nothing_buckles_below_the_threshold_and_all_is_taken_up_above():
    amounts = buckling(np.array([-0.1, 0.0, 0.05, 0.06, 0.1, 5.0]), 0.05)
    np.testing.assert_array_equal(amounts[:3], 0)
    assert (np.diff(amounts[2:]) > 0).all()
    assert 0 < amounts[3] < amounts[-1] <= 1


def test_it_is_no_polynomial():
    """The slope is steepest where it begins: as the root, not as a power."""
    beyond = buckling(0.05 + np.array([1e-6, 4e-6]), 0.05)
    assert beyond[1] / beyond[0] == pytest.approx(2, rel=0.1)


def test_furrows_are_narrow_and_mean_nothing_on_average():
    phase = np.linspace(0, 2 * np.pi, 2001)[:-1]
    profile = furrows(phase)
    assert abs(profile.mean()) < 1e-3
    assert profile.argmin() == 0
    assert (profile < 0).mean() < 0.5
    np.testing.assert_allclose(furrows(phase + 2 * np.pi), profile, atol=1e-9)
