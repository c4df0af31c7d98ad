"""Colours of scans: the skin's own, but for the faults asked for."""

from dataclasses import replace

import numpy as np
import pytest

from mien.stage.sensors.scan_photo import PhotoConfig, photographed

PLAIN = PhotoConfig()


@pytest.fixture
def sample():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(4000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.full((4000, 3), [0.6, 0.5, 0.4]), normals, np.zeros(4000)


def taken(sample, seed=1, **faults):
    return photographed(*sample, replace(PLAIN, **faults), np.random.default_rng(seed))


def test_without_faults_colours_are_the_skins(sample):
    np.testing.assert_allclose(taken(sample), sample[0], atol=1e-12)


def test_exposure_is_one_factor_a_scan(sample):
    gains = np.array([taken(sample, seed, exposure=0.5)[0] for seed in range(300)]) ** 2.2 / sample[0][0] ** 2.2
    np.testing.assert_allclose(gains[:, 0], gains[:, 2], rtol=1e-9)
    np.testing.assert_allclose(np.log2(gains[:, 0]).std(), 0.5, rtol=0.15)


def test_white_balance_differs_between_channels(sample):
    gain = taken(sample, white_balance=0.1)[0] / sample[0][0]
    assert np.ptp(gain) > 0.01


def test_noise_is_as_asked(sample):
    np.testing.assert_allclose((taken(sample, noise=5.0) - sample[0]).std() * 255, 5.0, rtol=0.05)


def test_a_lamp_darkens_what_it_does_not_face(sample):
    colour = taken(sample, shading=0.5)
    assert colour.max() <= 0.6 + 1e-9
    np.testing.assert_allclose(colour[:, 0].min() ** 2.2, 0.5 * 0.6**2.2, rtol=0.02)


def test_hair_covers_the_skin(sample):
    paint, normals, _ = sample
    dark = photographed(paint, normals, np.full(4000, 5.0), PLAIN, np.random.default_rng(0))
    assert dark.max() < 0.3
