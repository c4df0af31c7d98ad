"""The step from frame to frame: what must never poison a state."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import tracking_stage as stage
from mien.depth import RGBDFrame
from mien.errors import BadInput
from mien.tracking.tracker import finite, step
from mien.tracking.tracker_context import initial_state, tracker_context

BAD = 3
"""The frame in which something is wrong."""


@cache
def scene():
    """Seven frames, their landmarks and the context."""
    rig, context = stage.person(), tracker_context(stage.model(), stage.CAMERA)
    weights, poses = stage.talk(rig, 7), stage.sway(7)
    frames = [stage.sensed(rig, w, T, t / 30, 0.5, t) for t, (w, T) in enumerate(zip(weights, poses, strict=True))]
    return context, frames, [stage.told(rig, w, T) for w, T in zip(weights, poses, strict=True)]


def walked(change):
    """Results of a walk in which `change` spoils one frame and its landmarks."""
    context, frames, marks = scene()
    state, results = initial_state(context), []
    for t, (frame, seen) in enumerate(zip(frames, marks, strict=True)):
        state, result = step(context, *(change(frame, seen) if t == BAD else (frame, seen)), state)
        results.append(result)
    return results


def one_landmark(frame, seen):
    points = seen.points.copy()
    points[[13, 145]] = np.nan
    return frame, replace(seen, points=points)


def all_landmarks(frame, seen):
    return frame, replace(seen, points=np.full_like(seen.points, np.inf))


def a_score(frame, seen):
    return frame, replace(seen, scores={**seen.scores, "mouthSmileLeft": float("nan"), "eyeBlinkLeft": 1e9})


def some_depth(frame, seen):
    depth = frame.depth.copy()
    depth[118:122], depth[90:93] = np.inf, np.nan
    return RGBDFrame(frame.color, depth, frame.time), seen


@pytest.mark.parametrize("change", [one_landmark, all_landmarks, a_score, some_depth])
def test_what_is_not_finite_is_left_out_and_never_stays(change):
    results, plain = walked(change), walked(lambda frame, seen: (frame, seen))
    for result, usual in zip(results, plain, strict=True):
        assert result.tracked
        assert np.isfinite(result.vertices).all()
        assert np.isfinite(result.weights).all()
        assert np.abs(result.vertices - usual.vertices).max() < 3.0


def test_a_head_is_found_by_the_landmarks_that_are_numbers():
    context, frames, marks = scene()
    _, spoilt = one_landmark(frames[0], marks[0])
    _, result = step(context, frames[0], spoilt, initial_state(context))
    assert result.tracked
    assert np.isfinite(result.vertices).all()


def test_a_time_that_is_no_number_is_refused():
    with pytest.raises(BadInput, match="time"):
        RGBDFrame(None, np.ones((2, 2), np.float32), float("nan"))


def test_a_state_with_one_number_that_is_none_is_no_state_to_go_on_from():
    context, *_ = scene()
    state = initial_state(context)
    assert finite(state)
    vertices = state.vertices.copy()
    vertices[7, 1] = np.nan
    assert not finite(replace(state, vertices=vertices))
    pose = replace(state.T_camera_face, translation=np.array([0.0, np.inf, 0.0]))
    assert not finite(replace(state, T_camera_face=pose))
