"""The fit's settings: what each is good for, at its default."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.tracking.fit import fit_blendshapes
from mien.tracking.terms.fit_config import BlendshapeFitConfig, colour_alone

CONFIG = BlendshapeFitConfig()


@pytest.fixture(scope="module")
def scene():
    return stage.moment()


def fitted(scene, config, shift=0.0):
    """The fit of a moment whose landmarks are all wrong by `shift` mm to one side."""
    m, T, _, observation = scene
    rays = observation.rays + np.array([shift / 600.0, 0.0])
    return fit_blendshapes(m, observation.moved(rays), np.zeros(m.shapes), T, config)


def test_beside_depth_an_error_common_to_all_landmarks_says_nothing(scene):
    def swayed(config):
        return np.abs(fitted(scene, config, 4.0).weights - fitted(scene, config).weights).max()

    absolute = replace(CONFIG, head_relative_landmarks=False)
    assert swayed(CONFIG) < 0.2 * swayed(absolute)


def test_large_shapes_cost_more_than_small_ones(scene):
    m = scene[0]
    plain = fitted(scene, replace(CONFIG, l1_per_mm=0.0)).weights
    assert (m.size * fitted(scene, CONFIG).weights).sum() < (m.size * plain).sum() - 1e-3


def test_without_depth_landmarks_that_err_move_fewer_shapes(scene):
    """Landmarks of a calm face, badly told: less is made of it than by the weights beside depth."""
    m, T, _, observation = scene
    calm = T.apply(m.landmark_neutral)
    rays, off = calm[:, :2] / calm[:, 2:], np.random.default_rng(0).normal(0, 5.0 / 600.0, (478, 2))
    alone = replace(observation, depth=None).moved(rays + off)

    def invented(config):
        return fit_blendshapes(m, alone, np.zeros(m.shapes), T, config).weights.sum()

    assert 0 < invented(colour_alone()) < 0.6 * invented(replace(CONFIG, alone=colour_alone().alone))
