"""Weight curves: natural timing, no conflicts, determinism."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.faces.arkit import ARKIT_NAMES
from mien.stage.script.poses import EMOTIONS, GROUPS, UNITS_IN_TURN, VISEMES
from mien.stage.script.script import OPPOSED, frozen, minimum_jerk, ramp, random_performance, scripted, settle_conflicts


@pytest.fixture(scope="module", params=["scripted", "random"])
def script(request):
    return scripted(120.0, 20.0) if request.param == "scripted" else random_performance(120.0, 10.0, seed=3)


def test_weights_are_weights(script):
    assert script.weights.shape[1] == 52
    assert script.weights.min() >= 0
    assert script.weights.max() <= 1


def test_opposed_units_never_add_up_to_more_than_one(script):
    for a, b in OPPOSED:
        for side in ("", "Left", "Right"):
            if a + side in ARKIT_NAMES and b + side in ARKIT_NAMES:
                both = script.weights[:, ARKIT_NAMES.index(a + side)] + script.weights[:, ARKIT_NAMES.index(b + side)]
                assert both.max() <= 1 + 1e-12


def test_the_mouth_closes_no_further_than_the_jaw_is_open(script):
    weights = script.weights
    assert (weights[:, ARKIT_NAMES.index("mouthClose")] <= weights[:, ARKIT_NAMES.index("jawOpen")]).all()


def test_motion_is_smooth_at_120_hertz(script):
    steps = np.abs(np.diff(script.weights, axis=0))
    gaze = [i for i, name in enumerate(ARKIT_NAMES) if name.startswith("eyeLook")]
    assert np.delete(steps, gaze, axis=1).max() < 0.35
    assert np.delete(np.abs(np.diff(steps, axis=0)), gaze, axis=1).max() < 0.2


def test_there_are_blinks_of_both_eyes(script):
    shut = script.weights[:, [ARKIT_NAMES.index("eyeBlinkLeft"), ARKIT_NAMES.index("eyeBlinkRight")]].min(axis=1) > 0.95
    assert np.count_nonzero(np.diff(shut.astype(int)) == 1) >= 2


def test_seeds_decide():
    a, b, c = (random_performance(60.0, 5.0, seed=s).weights for s in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert np.abs(a - c).max() > 0.1


def test_a_ramp_by_hand():
    times = np.array([0.0, 1.0, 1.5, 2.0, 3.0, 4.0])
    np.testing.assert_allclose(ramp(times, 0.0, 1.0, 1.0, 2.0), [0, 1, 1, 1, 0.5, 0], atol=1e-12)
    np.testing.assert_allclose(minimum_jerk(np.array([-1.0, 0.5, 2.0])), [0, 0.5, 1])


def test_conflicts_are_settled_by_hand():
    weights = np.zeros((1, 52))
    index = ARKIT_NAMES.index
    units = [index("mouthSmileLeft"), index("mouthFrownLeft"), index("mouthClose")]
    weights[0, units] = [1.0, 1.0, 0.7]
    np.testing.assert_allclose(settle_conflicts(weights)[0, units], [0.5, 0.5, 0.0])


def test_frozen_is_the_mean():
    weights = np.random.default_rng(0).random((5, 52))
    np.testing.assert_allclose(frozen(weights), np.tile(weights.mean(axis=0), (5, 1)))


def test_poses_name_real_units():
    names = {unit for table in (VISEMES, EMOTIONS, GROUPS) for pose in table.values() for unit in pose}
    assert names | set(UNITS_IN_TURN) <= set(ARKIT_NAMES)


@pytest.mark.parametrize(("rate", "seconds", "word"), [(5.0, 20.0, "rate"), (60.0, 1.0, "seconds")])
def test_impossible_sessions_are_refused(rate, seconds, word):
    with pytest.raises(BadInput, match=word):
        scripted(rate, seconds)
