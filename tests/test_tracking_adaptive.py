"""The Laplacian deformation, the adaptive space, the features' standing errors."""

import numpy as np
import pytest
import scipy.sparse as sp

import tracking_stage as stage
from mien._kernels import track
from mien.landmarks.on_rig import FEATURES
from mien.mesh import vertex_normals
from mien.tracking.adaptive import (
    DeformConfig,
    LaplacianDeformation,
    anchor_space,
    depth_offsets,
    feature_offsets,
    weighted_subspace,
)
from mien.tracking.adaptive import _smoothness as smoothness
from mien.tracking.preprocess_frame import PreprocessFrameConfig, preprocess_frame
from mien.tracking.rigid import RigidConfig, correspond


@pytest.fixture(scope="module")
def deformation():
    return LaplacianDeformation(stage.model())


@pytest.fixture(scope="module")
def noise():
    rng = np.random.default_rng(0)
    return rng.normal(size=(len(stage.model().front), 3)), rng.normal(size=(len(FEATURES), 3))


def test_the_solution_is_that_of_the_stacked_rows(deformation, noise):
    """K = [Q; w1 I; w2 L] written out, tall, and solved by its normal equations (eq. 7)."""
    m, c, (offsets, features) = stage.model(), deformation.config, noise
    inner = np.flatnonzero(~m.rim)
    E, area = m.picks[:, inner], (m.share * len(m.share))[inner]
    KtK = c.features * E.T @ E + sp.diags(c.w1**2 * area) + c.w2**2 * c.length**4 * smoothness(m)[inner][:, inner]
    right = c.features * E.T @ features + c.w1**2 * area[:, None] * offsets[inner]
    found = deformation.with_depth(offsets, features)[inner]
    np.testing.assert_allclose(KtK @ found, right, atol=2e-4 * np.abs(right).max())


def test_the_rim_stays(deformation, noise):
    assert (deformation.with_depth(*noise)[stage.model().rim] == 0).all()
    assert (deformation.with_features(noise[1])[stage.model().rim] == 0).all()


def test_depth_noise_is_smoothed_and_slow_offsets_are_followed(deformation, noise):
    m = stage.model()
    none = np.zeros((len(FEATURES), 3))
    even = noise[0] / np.sqrt(m.share * len(m.share) + 0.01)[:, None]
    calmed = deformation.with_depth(even, none)
    assert m.share @ (calmed**2).sum(1) < 0.15 * (m.share @ (even**2).sum(1))
    middle = np.exp(-(((m.neutral - m.centre) ** 2).sum(1)) / 40**2)
    wave = middle[:, None] * np.array([0.0, 0.0, 2.0])
    error = np.linalg.norm(deformation.with_depth(wave, none) - wave, axis=1)
    assert m.share @ error < 0.12 * (m.share @ np.linalg.norm(wave, axis=1))


def test_the_feature_response_is_the_solution_without_depth(noise):
    config = DeformConfig(w1=1e-6, features=0.5, output_features=0.5, length=0.2, output_length=0.2)
    both = LaplacianDeformation(stage.model(), config)
    expected = both.with_depth(np.zeros_like(noise[0]), noise[1])
    np.testing.assert_allclose(both.with_features(noise[1]), expected, atol=2e-3)


def test_weights_of_the_paper_are_the_defaults(deformation):
    assert (deformation.config.w1, deformation.config.w2) == (0.1, 100.0)


def normals_of(m):
    return track.vertex_normals(m.neutral, m.faces)


def seen(weights, T, base=None):
    rig = stage.person()
    frame, marks = stage.sensed(rig, weights, T), stage.told(rig, weights, T)
    return preprocess_frame(frame, stage.CAMERA, base, marks, PreprocessFrameConfig(radius=0))


def test_depth_and_features_pull_the_neutral_to_the_expression(deformation):
    rig, m, T = stage.person(), stage.model(), stage.pose((0.1, 0.2, 0))
    truth = stage.named(rig, cheekPuff=0.5, jawOpen=0.1)
    observation = seen(truth, T)
    match = correspond(m.neutral, normals_of(m), T, observation, RigidConfig())
    features = feature_offsets(m, m.neutral, observation, T, 12.0)
    v2 = m.neutral + deformation.with_depth(depth_offsets(match, T), features)
    normals = vertex_normals(m.blend(truth).astype(float), m.faces)
    seen_at = m.share * (match.weight > 0)
    before, after = (seen_at @ np.abs(((v - m.blend(truth)) * normals).sum(1)) for v in (m.neutral, v2))
    assert after < 0.3 * before


def test_feature_offsets_end_on_the_line_of_sight():
    """Eq. 4 with its right-hand side put right: q lies on the feature's line of sight."""
    rig, m, T = stage.person(), stage.model(), stage.pose((0.1, 0.2, 0))
    observation = seen(stage.named(rig, jawOpen=0.2), T)
    wanted = feature_offsets(m, m.neutral, observation, T, 50.0, use_depth=False)
    goal = T.apply(m.picks @ m.neutral.astype(float) + wanted)
    np.testing.assert_allclose(goal[:, :2] / goal[:, 2:], observation.rays[list(FEATURES)], atol=1e-9)
    assert not feature_offsets(m, m.neutral, observation.without_landmarks(), T, 50.0).any()


def test_a_feature_far_off_is_not_believed():
    rig, m, T = stage.person(), stage.model(), stage.pose()
    observation = seen(np.zeros(len(rig.names)), T)
    rays = observation.rays.copy()
    rays[FEATURES[3]] += 0.1
    wanted = feature_offsets(m, m.neutral, observation.moved(rays), T, 12.0)
    assert not wanted[3].any()


def test_depth_offsets_are_along_the_surface_s_normal():
    m, T = stage.model(), stage.pose()
    observation = seen(np.zeros(m.shapes), stage.pose(shift=(3, 0, 4)))
    match = correspond(m.neutral, normals_of(m), T, observation, RigidConfig())
    offsets = depth_offsets(match, T) @ T.rotation.T
    assert np.abs(np.cross(offsets, match.plane)).max() < 1e-3
    gaps = ((match.found - match.points) * match.plane).sum(1)
    np.testing.assert_allclose((offsets * match.plane).sum(1), gaps, atol=1e-3)


def test_anchors_are_orthonormal_by_area_and_span_the_blendshapes():
    m = stage.model()
    anchors = anchor_space(m)
    U, D = anchors.shapes.T.astype(float), np.repeat(m.share, 3)[:, None]
    np.testing.assert_allclose(U.T @ (D * U), np.eye(U.shape[1]), atol=1e-4)
    shape = m.basis @ np.random.default_rng(1).random(m.shapes).astype(np.float32)
    left = shape - anchors.project(shape)
    assert m.share @ (left**2).sum(1) < 1e-3 * (m.share @ (shape**2).sum(1))
    np.testing.assert_allclose(anchors.project(anchors.project(shape)), anchors.project(shape), atol=1e-4)


def test_a_subspace_from_plain_columns():
    m = stage.model()
    columns = np.linalg.qr(np.random.default_rng(2).normal(size=(m.neutral.size, 3)))[0]
    space = weighted_subspace(m, columns.T)
    shape = (np.array([1.0, -2.0, 0.5], np.float32) @ space.shapes).reshape(-1, 3)
    np.testing.assert_allclose(space.project(shape), shape, atol=1e-3 * np.abs(shape).max())
