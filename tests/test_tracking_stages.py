"""The tracker's stages, each switched off or on by itself."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.tracking.preprocess_frame import FrameObservation
from mien.tracking.rigid import damp_pose
from mien.tracking.stages import carry_landmarks, damped, outside_of, rms, weights_anew
from mien.tracking.tracker_context import TrackConfig, initial_state, tracker_context


@pytest.fixture(scope="module")
def context():
    return tracker_context(stage.model(), stage.CAMERA)


def test_weights_are_solved_anew_only_if_wanted(context):
    model = context.model
    truth = stage.named(model.rig, jawOpen=0.5)
    fitted = np.zeros(model.shapes)
    mesh = model.blend(truth)
    np.testing.assert_array_equal(weights_anew(context, mesh, fitted), fitted)
    anew = replace(context, config=TrackConfig(anew=True))
    assert weights_anew(anew, mesh, fitted)[model.rig.index("jawOpen")] > 0.4


def test_late_landmarks_go_along_with_the_head(context):
    model, then, now = context.model, stage.pose(), stage.pose(shift=(20.0, 0.0, 0.0))
    state = replace(initial_state(context), T_camera_face=then)
    rays = then.apply(model.landmark_neutral)
    seen = FrameObservation(None, stage.CAMERA, rays[:, :2] / rays[:, 2:])
    points = now.apply(model.landmark_neutral)
    carried = carry_landmarks(seen, state, now, model)
    np.testing.assert_allclose(carried.rays, points[:, :2] / points[:, 2:], atol=1e-9)


def test_small_motion_of_the_head_is_held_back_and_a_found_head_is_where_it_was_found(context):
    before, now = stage.pose(), stage.pose(shift=(0.3, 0.0, 0.0))
    state = replace(initial_state(context), T_camera_face=before, lost=False)
    held = damped(context, state, now).translation[0] - before.translation[0]
    assert held == pytest.approx(0.15, abs=1e-3)
    assert damped(context, replace(state, lost=True), now) is now
    off = replace(context, config=TrackConfig(damp_pose_mm=0.0))
    assert damped(off, state, now).translation[0] == pytest.approx(now.translation[0])
    assert damp_pose(np.eye(3), np.zeros(3), before, before, 0.3).translation[0] == before.translation[0]


def test_what_the_anchors_can_say_is_not_outside(context):
    model = context.model
    said = model.blend(stage.named(model.rig, mouthSmileLeft=0.7)) - model.neutral
    assert rms(model, outside_of(context.anchors, said)) < 0.02 * rms(model, said)
