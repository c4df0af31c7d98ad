"""Standing errors of the landmarker: learnt from offsets and scores that are told, and taken out."""

from dataclasses import replace

import numpy as np

import tracking_stage as stage
from mien.landmarks.on_rig import FEATURES
from mien.tracking.landmark_bias import (
    BiasConfig,
    learn_baseline,
    learn_bias,
    no_baseline,
    no_bias,
    subtract_baseline,
    subtract_bias,
)
from mien.tracking.preprocess_frame import FrameObservation, PreprocessFrameConfig, preprocess_frame


def seen(weights, T, base=None):
    rig = stage.person()
    frame, marks = stage.sensed(rig, weights, T), stage.told(rig, weights, T)
    return preprocess_frame(frame, stage.CAMERA, base, marks, PreprocessFrameConfig(radius=0))


def test_standing_errors_that_go_with_the_turn_are_learnt_and_taken_out():
    m, config = stage.model(), BiasConfig(memory=200.0, caution=2.0)
    rng, bias = np.random.default_rng(3), no_bias(config)
    slope = rng.normal(0, 0.8, (len(FEATURES), 2))
    slope -= np.median(slope, axis=0)
    errors = []
    for _ in range(120):
        yaw = rng.uniform(-0.3, 0.3)
        T = stage.pose((0.0, yaw, 0.0))
        points = T.apply(m.picks @ m.neutral.astype(float))
        rays = np.zeros((478, 2))
        wrong = slope * yaw / 0.2
        rays[list(FEATURES)] = (points[:, :2] + wrong) / points[:, 2:]
        raw = FrameObservation(None, stage.CAMERA, rays)
        better = subtract_bias(raw, bias, m, T, config)
        left = (better.rays[list(FEATURES)] - points[:, :2] / points[:, 2:]) * points[:, 2:]
        errors.append(np.linalg.norm(left - np.median(left, 0), axis=1).mean())
        bias = learn_bias(bias, m, m.neutral, raw, T, config)
    assert np.mean(errors[-20:]) < 0.1 * np.mean(errors[:5])


def test_no_memory_means_no_correction():
    m, T, config = stage.model(), stage.pose(), BiasConfig(memory=0.0)
    observation = seen(np.zeros(m.shapes), T)
    assert not learn_bias(no_bias(), m, m.neutral, observation, T, config).coefficients.any()
    assert subtract_bias(observation, no_bias(), m, T, config) is observation
    blind = replace(observation, rays=None)
    assert subtract_bias(blind, no_bias(), m, T, BiasConfig()) is blind


def test_scores_are_counted_from_what_the_landmarker_scores_at_rest():
    config, baseline = BiasConfig(calm=100.0), no_baseline(2)
    for t in range(300):
        truth = np.array([np.sin(t / 30) ** 2, 0.0])
        baseline = learn_baseline(baseline, 0.4 + 0.6 * truth, truth + 0.3 * (truth - 0.5) * [1, 0], config)
    np.testing.assert_allclose(baseline.level[1], 0.4, atol=1e-6)
    np.testing.assert_allclose(subtract_baseline(np.array([0.2, 0.7]), baseline)[1], 0.5, atol=1e-6)
    assert subtract_baseline(np.array([0.0, 0.4]), baseline).max() < 1e-6
    unseen = learn_baseline(baseline, np.full(2, np.nan), np.zeros(2), config)
    np.testing.assert_array_equal(unseen.level, baseline.level)
    assert learn_baseline(baseline, np.ones(2), np.zeros(2), BiasConfig(calm=0.0)) is baseline
