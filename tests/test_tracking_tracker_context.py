"""What the tracker is set up with, and what it begins from."""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np

import tracking_stage as stage
from mien.tracking.tracker_context import NoTimer, StageTimer, TrackConfig, initial_state, timed, tracker_context


class Log:
    """A timer that remembers."""

    def __init__(self):
        self.entered = []

    @contextmanager
    def stage(self, name):
        self.entered.append(name)
        yield


def test_a_timer_hears_of_each_stage_and_changes_nothing():
    context = replace(tracker_context(stage.model(), stage.CAMERA), timer=Log())

    @timed("adding")
    def add(context, a, b):
        """Add."""
        return a + b

    assert (add(context, 2, 3), context.timer.entered, add.__doc__) == (5, ["adding"], "Add.")
    assert isinstance(NoTimer(), StageTimer)


def test_nothing_is_known_before_the_first_frame():
    context = tracker_context(stage.model(), stage.CAMERA, TrackConfig())
    state = initial_state(context)
    assert (state.lost, state.weights, state.correctives, state.time) == (True, None, None, -np.inf)
    np.testing.assert_array_equal(state.vertices, context.model.neutral)
    assert not state.landmark_bias.coefficients.any()
    assert state.baseline.count == state.reference.frames == 0
