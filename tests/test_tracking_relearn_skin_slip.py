"""Slip of the skin: none where the model is right, and as far as the model is off."""

import numpy as np

import relearn_stage
import tracking_stage as stage
from mien.tracking.relearn.front_chart import ChartedFrame, charted
from mien.tracking.relearn.skin_slip import SlipConfig, calm_reference, normalised, skin_slip


def test_normalised_pictures_know_neither_the_light_nor_its_strength():
    config = SlipConfig(faint=0.0)
    grey = np.random.default_rng(0).normal(128, 20, (60, 50))
    np.testing.assert_allclose(normalised(0.5 * grey + 30, config), normalised(grey, config), atol=1e-5)
    grey[:20] = np.nan
    assert np.isnan(normalised(grey, config)[:20]).all()
    assert np.isfinite(normalised(grey, config)[20:]).all()


def test_the_reference_shows_what_half_of_the_calm_frames_do():
    grey = np.random.default_rng(1).normal(128, 20, (3, 40, 40))
    grey[0, :10] = grey[1, :10] = np.nan
    grey[2, 20:] = 0.0  # one frame that shows something else
    found = calm_reference([ChartedFrame(g, np.zeros((40, 40, 3))) for g in grey], SlipConfig(around_mm=0.5))
    assert np.isnan(found[:10]).all()
    assert np.isfinite(found[10:]).all()


def test_slip_is_how_far_the_model_is_off_its_skin():
    m, chart, config = stage.model(), relearn_stage.chart(), relearn_stage.CONFIG
    T, neutral = stage.pose(distance=500.0), m.neutral.astype(float)
    color, depth = relearn_stage.picture(stage.person(), np.zeros(52), T)
    rest = charted(chart, color, depth, relearn_stage.CAMERA, T, neutral)
    reference = calm_reference([rest], config)
    assert np.abs(skin_slip(chart, rest, reference, config)).max() < 0.05
    off = charted(chart, color, depth, relearn_stage.CAMERA, T, neutral + np.array([1.5, -0.8, 0]))
    slip = skin_slip(chart, off, reference, config)
    there = slip.any(axis=1)
    assert there[chart.shown].mean() > 0.7
    assert not there[~chart.shown].any()
    np.testing.assert_allclose(np.median(slip[there, :2], axis=0), [-1.5, 0.8], atol=0.15)
