"""The blendshape fit: the depth term's derivative, and known weights found again."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien._kernels import track
from mien.tracking.fit import depth_term, first_frame_fit, fit_blendshapes, refine_pose
from mien.tracking.preprocess_frame import preprocess_frame
from mien.tracking.rigid import RigidConfig, correspond
from mien.tracking.terms.fit_config import BlendshapeFitConfig
from mien.transforms import Transform

PLAIN = BlendshapeFitConfig(robust_scale_mm=1e9, features=13.8, gaps=2.0)


@pytest.fixture(scope="module")
def scene():
    return stage.moment()


def matched(m, x, T, observation):
    normals = track.vertex_normals(m.blend(x), m.faces)
    return correspond(m.blend(x), normals, T, observation, RigidConfig())


def test_the_depth_term_has_the_right_derivative(scene):
    """J'r falls by J'J times the change."""
    m, T, _, observation = scene
    x, centre = np.full(m.shapes, 0.2), T.apply(m.centre[None])[0]
    match = matched(m, x, T, observation)
    (A, b), _, covered = depth_term(m, match, T, centre, PLAIN)
    z = np.random.default_rng(1).normal(0, 1e-2, m.shapes + 6)
    points = stage.turned(T, z, centre).apply(m.blend(x + z[:-6]).astype(float)).astype(np.float32)
    (_, after), _, _ = depth_term(m, replace(match, points=points), T, centre, PLAIN)
    assert np.abs(b - A @ z - after).max() < 0.02 * np.abs(A @ z).max()
    assert 0.3 < covered < 1.0


def test_weights_do_not_depend_on_how_finely_the_mesh_is_cut(scene):
    m, T, _, observation = scene
    match = matched(m, np.zeros(m.shapes), T, observation)
    half = replace(match, weight=match.weight * 0.5)
    centre = T.apply(m.centre[None])[0]
    whole, less = (depth_term(m, k, T, centre, PLAIN)[0][0] for k in (match, half))
    np.testing.assert_allclose(less, 0.5 * whole, rtol=1e-3, atol=1e-4 * np.abs(whole).max())
    assert abs(m.share.sum() - 1) < 1e-5


def test_known_weights_and_pose_are_found(scene):
    m, _, truth, observation = scene
    light = BlendshapeFitConfig(
        rounds=8, ridge=0.5, l1=0.5, temporal_weight=0.0, features=13.8, head_relative_landmarks=False,
        refine_pose_mm=0.0, symmetry=0.0, opposition=0.0,
    )  # fmt: skip
    start = stage.pose((0.09, 0.16, 0.05), (2, 2, 2))
    found = fit_blendshapes(m, observation, np.zeros(m.shapes), start, light)
    moved_by = np.linalg.norm(m.blend(found.weights) - m.blend(truth), axis=1)
    assert m.share @ moved_by < 0.15
    assert np.abs(found.weights - truth).mean() < 0.03
    assert found.error < 0.2
    assert ((found.weights >= 0) & (found.weights <= 1)).all()


def test_the_defaults_find_the_expression_in_noise():
    rig, m, T = stage.person(), stage.model(), stage.pose((0.1, -0.1, 0))
    truth = stage.named(rig, jawOpen=0.4, mouthPucker=0.5)
    frame, marks = stage.sensed(rig, truth, T, noise=0.8), stage.told(rig, truth, T, noise=0.3)
    observation = preprocess_frame(frame, stage.CAMERA, None, marks)
    found = fit_blendshapes(m, observation, np.zeros(m.shapes), T)
    error = m.share @ np.linalg.norm(m.blend(found.weights) - m.blend(truth), axis=1)
    assert error < 0.35 * (m.share @ np.linalg.norm(m.blend(truth) - m.neutral, axis=1))


def test_without_depth_landmarks_alone_drive_the_fit(scene):
    m, T, _, observation = scene
    blind = replace(observation, depth=None)
    found = fit_blendshapes(m, blind, np.zeros(m.shapes), T, BlendshapeFitConfig(rounds=5))
    assert found.weights[m.rig.index("jawOpen")] == pytest.approx(0.35, abs=0.12)
    assert found.weights[m.rig.index("mouthSmileLeft")] > 2 * found.weights[m.rig.index("mouthSmileRight")]
    assert np.isnan(found.error)


def test_a_head_just_found_is_not_held_at_rest(scene):
    m, T, truth, observation = scene
    first, later = (fit_blendshapes(m, observation, np.zeros(m.shapes), T, config).weights
                    for config in (first_frame_fit(BlendshapeFitConfig()), BlendshapeFitConfig()))  # fmt: skip
    jaw = m.rig.index("jawOpen")
    assert later[jaw] < first[jaw] <= truth[jaw] + 0.05
    assert first_frame_fit(BlendshapeFitConfig()).temporal_weight == 0


def test_the_pose_is_measured_anew_on_what_holds_still(scene):
    """An ICP step from a pose that is 1 mm off brings the known face back; what has no weight has no say."""
    m, T, truth, observation = scene
    off = Transform(T.rotation, T.translation + np.array([0.0, 0.0, 1.0]))
    match = matched(m, truth, off, observation)
    found = refine_pose(m, m.blend(truth), match, off, m.share, BlendshapeFitConfig())
    assert abs(found.translation[2] - T.translation[2]) < 0.2
    bulging = m.neutral[:, 1] < m.centre[1]
    swollen = m.blend(truth) + bulging[:, None] * np.array([0, 0, 3], np.float32)
    whole, still = (refine_pose(m, swollen, match, T, w, BlendshapeFitConfig()).translation[2] - T.translation[2]
                    for w in (m.share, m.share * ~bulging))  # fmt: skip
    assert abs(still) < 0.5 * abs(whole)
