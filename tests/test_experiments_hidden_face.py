"""The session with a headset: what its calibration plays, and how upper weights are scored."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.experiments.hidden_face import (
    CALIBRATION,
    HiddenFaceConfig,
    hidden_errors,
    in_turn,
    lower_skin,
    moments,
)
from mien.faces.arkit import ARKIT_NAMES
from worn_face import UPPER, under_headset


def test_every_expression_is_played_as_often_as_asked_and_rests_between():
    config = HiddenFaceConfig(each_s=1.0, times=3)
    weights = in_turn(CALIBRATION * config.times, config)
    assert len(weights) == 3 * len(CALIBRATION) * 15
    brow = weights[:, ARKIT_NAMES.index("browDownLeft")]
    assert (np.diff((brow > 0.9).astype(int)) == 1).sum() == 3
    np.testing.assert_allclose(weights[::15], 0.0, atol=1e-12)


@pytest.fixture(scope="module")
def found():
    return under_headset(replace(stage.person(), names=ARKIT_NAMES))


def test_errors_are_of_upper_shapes_without_gaze_and_of_lower_ones(found):
    true = found.truth.weights
    errors = hidden_errors(found)
    assert errors["upper"]["ours"] == 0
    assert errors["upper"]["zeros"] == errors["upper"]["frozen"] == np.sqrt((true[:, UPPER] ** 2).mean())
    lower = np.array([not name.startswith(("brow", "eye", "cheekSquint")) for name in ARKIT_NAMES])
    assert errors["lower"]["ours"] == np.sqrt((true[:, lower] ** 2).mean())


def test_moments_are_the_strongest_of_each_part_after_the_calm(found):
    strength = found.truth.weights.sum(1)
    assert moments(found, 2) == [2 + int(strength[2:5].argmax()), 5 + int(strength[5:].argmax())]


def test_a_mouth_that_is_not_moved_errs_by_its_motion(found):
    moved, frozen = lower_skin(found)
    assert moved > frozen > 0
