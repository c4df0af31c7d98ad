"""Smooth random fields: their statistics, and what a mirror makes of them."""

import numpy as np

from mien.stage.people.fields import mirrored_points, paired_field, smooth_field, symmetric_field

POINTS = np.random.default_rng(0).uniform(-90, 90, (4000, 3))


def test_mean_variance_and_smoothness():
    field = smooth_field(np.random.default_rng(1), (40.0, 80.0), channels=3, waves=64)
    values = field.at(POINTS)
    assert values.shape == (4000, 3)
    np.testing.assert_allclose(values.mean(axis=0), 0, atol=0.25)
    np.testing.assert_allclose(values.std(axis=0), 1, atol=0.25)
    near = field.at(POINTS + np.array([0.5, 0, 0]))
    assert np.abs(near - values).mean() < 0.1


def test_the_same_seed_gives_the_same_field():
    a, b, c = (smooth_field(np.random.default_rng(s), (40.0, 80.0)).at(POINTS) for s in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert np.abs(a - c).max() > 0.5


def test_mirrored_points_come_back():
    np.testing.assert_array_equal(mirrored_points(mirrored_points(POINTS)), POINTS)
    np.testing.assert_array_equal(mirrored_points(POINTS)[:, 0], -POINTS[:, 0])


def test_without_asymmetry_a_field_is_its_own_mirror_image():
    signs = np.array([-1.0, 1.0, 1.0])
    both = np.concatenate([POINTS, mirrored_points(POINTS)])
    here, there = np.split(symmetric_field(np.random.default_rng(3), both, (40.0, 80.0), signs, 0.0), 2)
    np.testing.assert_allclose(there, here * signs, atol=1e-9)
    lopsided, other = np.split(symmetric_field(np.random.default_rng(3), both, (40.0, 80.0), signs, 0.8), 2)
    assert np.abs(other - lopsided * signs).mean() > 0.2


def test_the_right_side_wears_the_left_side_s_field_mirrored():
    signs = np.array([1.0])
    left, right = paired_field(np.random.default_rng(4), POINTS, (40.0, 80.0), signs, 0.0)
    swapped, _ = paired_field(np.random.default_rng(4), mirrored_points(POINTS), (40.0, 80.0), signs, 0.0)
    np.testing.assert_allclose(right, swapped, atol=1e-9)
    assert np.abs(left - right).mean() > 0.2
