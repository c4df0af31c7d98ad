"""The tracker's stages, each switched off or on by itself."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.landmarks.on_rig import BROWS, FEATURES, OUTER_LIPS
from mien.solve import kalman
from mien.tracking.fit import FitResult
from mien.tracking.preprocess_frame import FrameObservation
from mien.tracking.rigid import damp_pose
from mien.tracking.stages import (
    adaptive_space,
    carry_landmarks,
    damped,
    distances,
    initial_blendshapes,
    learn_appearance,
    learn_correctives,
    learn_skin_motion,
    learn_standing_errors,
    observed_frame,
    output_deformation,
    remove_standing_errors,
    rigid_motion,
    rms,
    weights_anew,
)
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
    to_anchors, to_adaptive = distances(model, said, context.anchors, None)
    assert to_anchors == to_adaptive < 0.02 * rms(model, said)
    left = said - context.anchors.project(said)
    assert to_anchors == pytest.approx(rms(model, left), abs=0.01 * rms(model, said))


@pytest.fixture(scope="module")
def moment(context):
    """A state at a known pose, and a frame in which the head has moved on and smiles."""
    rig = context.model.rig
    then, now = stage.pose((0.0, 0.1, 0.0)), stage.pose((0.0, 0.13, 0.0), (4.0, -2.0, 3.0))
    truth = stage.named(rig, mouthSmileLeft=0.6, mouthSmileRight=0.6, jawOpen=0.2)
    state = replace(initial_state(context), T_camera_face=then, lost=False, time=0.0)
    frame, marks = stage.sensed(rig, truth, now, 1 / 30, 0.3), stage.told(rig, truth, now)
    return state, now, truth, observed_frame(context, frame, marks, state, then)


def test_the_head_is_followed_by_its_depth(context, moment):
    state, now, _, observation = moment
    found = rigid_motion(context, observation, state, state.T_camera_face)
    points = context.model.neutral[::40].astype(float)
    before, after = (np.linalg.norm(T.apply(points) - now.apply(points), axis=1).mean()
                     for T in (state.T_camera_face, found.T_camera_face))  # fmt: skip
    assert found.converged
    assert after < 0.5 * before
    blind = rigid_motion(context, replace(observation, depth=None), state, now)
    assert blind.T_camera_face is now


def test_coefficients_are_filtered_from_the_second_frame_on(context, moment):
    state, now, _, observation = moment
    first, filtered = initial_blendshapes(context, observation, now, replace(state, lost=True), 0.0)
    np.testing.assert_array_equal(filtered.values, first.weights)
    later = replace(state, weights=kalman.start(np.zeros(context.model.shapes)))
    calmed, _ = initial_blendshapes(context, observation, now, later, 1 / 300)
    off = replace(context, config=TrackConfig(smooth=False))
    plain, _ = initial_blendshapes(off, observation, now, later, 1 / 300)
    assert calmed.weights.sum() < 0.95 * plain.weights.sum()


def test_depth_and_features_bring_the_blend_nearer_to_the_face(context, moment):
    state, now, truth, observation = moment
    model = context.model
    goal = model.blend(truth)
    half = model.blend(0.5 * truth)
    sample, v3 = adaptive_space(context, observation, half, now, state)
    assert rms(model, v3 - goal) < 0.95 * rms(model, half - goal)
    assert rms(model, v3 - model.neutral - context.anchors.project(v3 - model.neutral)) < 1e-3
    assert sample is not None
    v4 = output_deformation(context, observation, half, now)
    seen = observation.rays[list(FEATURES)]

    def away(vertices):
        points = now.apply(model.features(vertices))
        return np.linalg.norm(points[:, :2] / points[:, 2:] - seen, axis=1).mean()

    assert away(v4) < 0.999 * away(half)


def test_standing_errors_are_learnt_and_taken_out(context, moment):
    state, now, truth, observation = moment
    model, wrong = context.model, np.zeros((40, 2))
    wrong[::2, 0] = 2.0
    z = now.apply(model.landmark_neutral)[list(FEATURES), 2:]
    rays = observation.rays.copy()
    rays[list(FEATURES)] += wrong / z
    spoilt = replace(observation.moved(rays), landmark_scores=np.full(model.shapes, 0.5))
    fit = FitResult(truth, now, 0.0, 1.0)
    learning = replace(state)
    for _ in range(60):
        bias, baseline = learn_standing_errors(context, spoilt, model.blend(truth), fit, learning)
        learning = replace(learning, landmark_bias=bias, baseline=baseline)
    mended = remove_standing_errors(context, spoilt, learning, now)
    left = (mended.rays - observation.rays)[list(FEATURES)] * z
    assert np.linalg.norm(left - np.median(left, axis=0), axis=1).mean() < 0.5
    assert np.nanmax(mended.landmark_scores[truth == 0]) < 0.1


def test_correctives_are_learnt_from_what_lies_outside(context):
    model, rng = context.model, np.random.default_rng(0)
    config = replace(context.config, pca=replace(context.config.pca, warm_up=7))
    eager = replace(context, config=config)
    learning = initial_state(eager)
    bump = np.exp(-((np.linalg.norm(model.neutral - model.neutral[900], axis=1) / 15) ** 2))
    learnt = []
    for _ in range(18):
        sample = (rng.uniform(1, 3) * bump[:, None] * np.array([0.0, 0, 4.0])).astype(np.float32)
        found = learn_correctives(eager, sample, model.neutral + sample, learning)
        learning = replace(learning, correctives=found.correctives)
        learnt.append(found.learnt)
    assert learnt[-4:] == [False, True, False, True]
    assert found.correctives is not None
    assert rms(model, sample - found.correctives.project(sample)) < 0.1 * rms(model, sample)
    silent = replace(eager, config=replace(config, correctives=False))
    assert not learn_correctives(silent, sample, model.neutral + sample, initial_state(silent)).learnt


def test_the_pose_is_measured_on_skin_that_was_seen_to_keep_still(context, moment):
    state, _, truth, _ = moment
    moved = learn_skin_motion(context, context.model.blend(truth), state)
    assert moved.frames == 1
    say = moved.pose_weights(context.model.share) / context.model.share
    near = np.linalg.norm(context.model.features(context.model.neutral)[:, None] - context.model.neutral, axis=2)
    mouth, brow = near[FEATURES.index(OUTER_LIPS[0])].argmin(), near[FEATURES.index(BROWS[0])].argmin()
    assert say[mouth] < 0.5 * say[brow]


def test_the_skin_is_remembered(context, moment):
    state, now, truth, observation = moment
    fit = FitResult(truth, now, 0.0, 1.0)
    found = learn_appearance(context, observation, context.model.blend(truth), fit, state)
    assert found.frames == 1
    assert found.count.max() == 1
