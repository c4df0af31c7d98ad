"""Every expression in every round."""

from itertools import pairwise

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.stage.script.repeated_script import REPEATED, repeated_script


def test_a_repeated_script_is_calm_then_has_every_expression_in_every_round():
    script = repeated_script(30.0, 12.0, seed=3)
    assert [name for name, _, _ in script.cues] == ["calm", *REPEATED, *(f"{name} again" for name in REPEATED)]
    _, start, end = script.cues[0]
    gaze = np.array([name.startswith(("eyeLook", "eyeBlink")) for name in stage.person().names])
    assert script.weights[start : end - 3][:, ~gaze].max() < 0.1
    assert all(script.weights[a:b][:, ~gaze].max() > 0.4 for _, a, b in script.cues[1:])
    ends = [(a, b) for _, a, b in script.cues]
    assert ends[0][0] == 0
    assert all(abs(b - c) <= 1 for (_, b), (c, _) in pairwise(ends))


def test_repeated_scripts_that_cannot_be():
    with pytest.raises(BadInput, match="there is no 'glee'; known are"):
        repeated_script(expressions=("glee",))
    with pytest.raises(BadInput, match=r"seconds: expected at least 6\.5, got 3"):
        repeated_script(seconds=3.0)
