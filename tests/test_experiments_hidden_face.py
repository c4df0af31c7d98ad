"""The session with a headset: what its calibration plays, and how upper weights are scored."""

from dataclasses import replace

import numpy as np

import tracking_stage as stage
from mien.experiments.hidden_face import CALIBRATION, HiddenFaceConfig, calibration_weights, upper_errors
from mien.faces.arkit import ARKIT_NAMES
from mien.rig import Performance
from mien.stage import Truth, make_performer
from mien.transforms import Transform


def test_every_expression_is_played_as_often_as_asked_and_rests_between():
    config = HiddenFaceConfig(each_s=1.0, times=3)
    weights = calibration_weights(config)
    assert len(weights) == 3 * len(CALIBRATION) * 15
    brow = weights[:, ARKIT_NAMES.index("browDownLeft")]
    assert (np.diff((brow > 0.9).astype(int)) == 1).sum() == 3
    np.testing.assert_allclose(weights[::15], 0.0, atol=1e-12)


def test_errors_are_of_upper_shapes_without_gaze():
    rng, frames = np.random.default_rng(0), 6
    rig = replace(stage.person(), names=ARKIT_NAMES)
    still = Transform(np.tile(np.eye(3), (frames, 1, 1)), np.zeros((frames, 3)))
    true = rng.uniform(0, 1, (frames, 52))
    seen = np.array([not name.startswith(("brow", "eyeB", "eyeS", "eyeW", "cheekSquint")) for name in ARKIT_NAMES])
    played = Performance(rig, np.where(seen, 0.0, true), still, 15.0, np.ones(frames, bool))
    calm = replace(played, weights=np.zeros_like(true))
    errors = upper_errors(Truth(make_performer(1), true, still, 15.0), played, calm)
    assert errors["gauges"] == 0
    assert errors["zeros"] == errors["frozen"] == np.sqrt((true[:, ~seen] ** 2).mean())
