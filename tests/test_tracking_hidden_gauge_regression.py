"""The regression from gauges to upper shapes, on channels that are mixes of them."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.io.gauge_file import GaugeTable
from mien.rig import Performance
from mien.tracking.hidden.gauge_regression import check_overlap, drive_upper, learn_gauges
from mien.transforms import Transform

RATE, FRAMES, READ_RATE = 15.0, 240, 61.0
PLAYED = ("browInnerUp", "eyeBlinkLeft", "eyeBlinkRight", "jawOpen")
MIX = np.array([[1.0, 0.2, 0.0, 0.5], [0.0, 1.0, 0.1, 0.0], [0.1, 0.0, 1.0, 0.0], [0.3, 0.3, 0.3, 0.0]])
"""What the four shapes say on each of the four channels."""


def take(seed, frames=FRAMES, noise=0.01, offset=3.0):
    """A performance and its gauges; each channel has a level of its own in each session."""
    rig, rng = stage.person(), np.random.default_rng(seed)
    weights = np.zeros((frames, len(rig.names)))
    for name in PLAYED:
        bumps = np.repeat(rng.random(frames // 10 + 1) > 0.85, 10)[:frames]
        weights[:, rig.index(name)] = bumps
    rotation = np.tile(np.eye(3), (frames, 1, 1))
    pose = Transform(rotation, np.zeros((frames, 3)))
    performance = Performance(rig, weights, pose, RATE, np.ones(frames, bool))
    times = np.arange(0, frames / RATE, 1 / READ_RATE)
    at = np.minimum(np.round(times * RATE).astype(int), frames - 1)
    shapes = weights[at][:, [rig.index(name) for name in PLAYED]]
    values = shapes @ MIX.T + rng.normal(0, noise, (len(times), 4)) + offset * rng.normal(0, 1, 4)
    return performance, GaugeTable(f"take {seed}", times, ("a", "b", "c", "d"), values)


def test_upper_shapes_come_back_from_another_session_and_the_lower_ones_stay():
    calibration, gauges = take(1)
    performance, others = take(2)
    regression = learn_gauges(calibration, gauges, others)
    assert set(regression.shapes) == set(PLAYED[:3])
    assert (regression.errors < 0.25 * regression.frozen).all()
    assert any("not learnt" in note and "browDownLeft" in note for note in regression.notes)
    unseen = performance.weights.copy()
    unseen[:, [performance.rig.index(name) for name in PLAYED[:3]]] = 0.0
    driven = drive_upper(replace(performance, weights=unseen), regression, others)
    np.testing.assert_allclose(np.abs(driven.weights - performance.weights).mean(0), 0, atol=0.08)
    jaw = performance.rig.index("jawOpen")
    np.testing.assert_array_equal(driven.weights[:, jaw], performance.weights[:, jaw])


def test_dead_and_missing_channels_are_named_and_left_out():
    calibration, gauges = take(1)
    _, others = take(2)
    dead = replace(others, values=np.where([True, True, True, False], others.values, 7.0))
    regression = learn_gauges(calibration, gauges, dead)
    assert regression.channels == ("a", "b", "c")
    assert "take 2: constant or empty, left out: d" in regression.notes
    regression = learn_gauges(calibration, gauges, others.only(("d", "b", "a")))
    assert regression.channels == ("a", "b", "d")
    assert "take 2: lacks c of take 1; left out" in regression.notes
    with pytest.raises(BadInput, match="no channel is left that both tables have"):
        learn_gauges(calibration, gauges, replace(others, channels=("w", "x", "y", "z")))


def test_what_cannot_be_learnt_from_is_said():
    calibration, gauges = take(1)
    short, few = take(3, frames=30)
    with pytest.raises(BadInput, match=r"2\.0 s of tracked face with readings; 5 s are the least"):
        learn_gauges(short, few, gauges)
    calm = replace(calibration, weights=np.zeros_like(calibration.weights))
    with pytest.raises(BadInput, match="at rest in all of the calibration"):
        learn_gauges(calm, gauges, gauges)
    late = replace(gauges, times=gauges.times + 1e6)
    with pytest.raises(BadInput, match=r"readings from 1000000\.0 to .* frames from 0 to 16\.0 s"):
        check_overlap(late, FRAMES, RATE)
    assert check_overlap(replace(gauges, times=gauges.times + 8.0), FRAMES, RATE) == pytest.approx(FRAMES / 2, abs=2)


def test_gaps_in_a_channel_are_bridged():
    calibration, gauges = take(1)
    holed = gauges.values.copy()
    holed[10:14, 0] = np.nan
    whole, bridged = (learn_gauges(calibration, replace(gauges, values=v), gauges) for v in (gauges.values, holed))
    np.testing.assert_allclose(whole.matrix, bridged.matrix, atol=0.05)
