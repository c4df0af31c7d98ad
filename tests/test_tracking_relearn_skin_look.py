"""What skin looks like, whatever the light."""

import numpy as np

from mien.tracking.relearn.front_chart import ChartedFrame
from mien.tracking.relearn.skin_look import LookConfig, calm_reference, normalised


def test_normalised_pictures_know_neither_the_light_nor_its_strength():
    config = LookConfig(faint=0.0)
    grey = np.random.default_rng(0).normal(128, 20, (60, 50))
    np.testing.assert_allclose(normalised(0.5 * grey + 30, config), normalised(grey, config), atol=1e-5)
    grey[:20] = np.nan
    assert np.isnan(normalised(grey, config)[:20]).all()
    assert np.isfinite(normalised(grey, config)[20:]).all()


def test_the_reference_shows_what_half_of_the_calm_frames_do():
    grey = np.random.default_rng(1).normal(128, 20, (3, 40, 40))
    grey[0, :10] = grey[1, :10] = np.nan
    grey[2, 20:] = 0.0  # one frame that shows something else
    found = calm_reference([ChartedFrame(g, np.zeros((40, 40, 3))) for g in grey], LookConfig(around_mm=0.5))
    assert np.isnan(found[:10]).all()
    assert np.isfinite(found[10:]).all()
