"""What faces do together, as weights that a face can take."""

import pytest

from mien.faces.arkit import ARKIT_NAMES
from mien.stage.script.poses import EMOTIONS, GROUPS, UNITS_IN_TURN, VISEMES, both


def test_both_sides_by_one_name():
    assert both(browDown=0.4) == {"browDownLeft": 0.4, "browDownRight": 0.4}


@pytest.mark.parametrize("poses", [VISEMES, EMOTIONS, GROUPS], ids=["visemes", "emotions", "groups"])
def test_every_pose_is_of_known_units_within_bounds(poses):
    for name, weights in poses.items():
        assert set(weights) <= set(ARKIT_NAMES), name
        assert all(0 < value <= 1 for value in weights.values()), name


def test_poses_differ_and_silence_is_the_neutral():
    every = [tuple(sorted(weights.items())) for poses in (VISEMES, EMOTIONS, GROUPS) for weights in poses.values()]
    assert len(set(every)) == len(every)
    assert VISEMES["silence"] == {}


def test_the_session_asks_for_each_unit_once():
    assert len(set(UNITS_IN_TURN)) == len(UNITS_IN_TURN)
