"""Gauges read strain: nothing at rest, shorter where the skin gathers, with noise and drift of the asked size."""

from dataclasses import replace

import numpy as np
import pytest

from mien.faces.arkit import ARKIT_NAMES
from mien.stage import Truth, make_performer
from mien.stage.sensors.strain_gauges import SEGMENTS, GaugeConfig, strain_readings
from mien.transforms import Transform

EXACT = GaugeConfig(rate=30.0, noise=0.0, drift=0.0, fit=0.0)


@pytest.fixture(scope="module")
def truth():
    """At rest, then brows up, then blinking."""
    weights = np.zeros((3, len(ARKIT_NAMES)))
    weights[1, [ARKIT_NAMES.index(name) for name in ("browInnerUp", "browOuterUpLeft", "browOuterUpRight")]] = 1
    weights[2, [ARKIT_NAMES.index(name) for name in ("eyeBlinkLeft", "eyeBlinkRight")]] = 1
    pose = Transform(np.tile(np.eye(3), (3, 1, 1)), np.zeros((3, 3)))
    return Truth(make_performer(3), weights, pose, 30.0)


def test_exact_gauges_tell_the_expression(truth):
    found = strain_readings(truth, EXACT)
    rest, brows, blink = (dict(zip(SEGMENTS, row, strict=True)) for row in found.values)
    assert max(map(abs, rest.values())) < 1e-9
    for side in ("left", "right"):
        assert brows[f"brow_inner_{side}"] < -0.05, "a raised brow gathers the forehead above it"
        assert blink[f"lid_{side}"] > 0.05, "a closing lid draws away from its brow"
        assert abs(blink[f"brow_inner_{side}"]) < 0.03


def test_faults_have_the_asked_size(truth):
    exact = strain_readings(truth, EXACT).values
    noise = strain_readings(truth, replace(EXACT, rate=5000.0, noise=0.004)).values[:, 0]
    assert np.diff(noise).std() / np.sqrt(2) == pytest.approx(0.004, rel=0.2)
    sessions = [strain_readings(truth, replace(EXACT, fit=0.02), seed).values - exact for seed in (1, 2)]
    assert np.ptp(sessions[0], axis=0).max() < 1e-12
    assert 0.005 < np.abs(sessions[0][0] - sessions[1][0]).mean() < 0.06
