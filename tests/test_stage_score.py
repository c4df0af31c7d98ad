"""Scores: the truth scores nothing, a frozen face scores the frozen baseline, known offsets score themselves."""

from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.rig import Performance, Rig
from mien.stage import MocapConfig, make_performer, marker_layout, perform, random_performance, score_performance
from mien.stage.score import score_vertices
from mien.takes.world import turn_y_up
from mien.transforms import Transform


@pytest.fixture(scope="module")
def truth():
    performer = make_performer(4)
    script = random_performance(30.0, 6.0, seed=2)
    return perform(performer, script.weights, 30.0, marker_layout(performer, 16), MocapConfig(up="+Z")).truth


def score(truth, vertices, T=None, **more):
    return score_vertices(vertices, truth.neutral.vertices, truth.T_lab_face if T is None else T, truth, **more)


def test_the_truth_scores_nothing(truth):
    s = score(truth, truth.vertices)
    for value in (s.absolute.max(), s.surface, s.surface_p95, s.expression.max(), s.ratio, s.ratio_strongest):
        assert value < 1e-4
    assert s.rotation.max() < 1e-6


def test_the_world_may_be_turned_upright(truth):
    s = score(truth, truth.vertices, turn_y_up(truth.T_lab_face))
    assert s.absolute.max() < 1e-6


def test_a_frozen_face_scores_the_frozen_baseline(truth):
    mean = truth.vertices().mean(axis=0)
    s = score(truth, lambda frames: np.broadcast_to(mean, (len(frames), *mean.shape)))
    np.testing.assert_allclose(s.expression, s.frozen, atol=1e-9)
    np.testing.assert_allclose(s.absolute, s.frozen, atol=1e-9)
    np.testing.assert_allclose([s.ratio, s.ratio_strongest], 1.0)


def test_the_frozen_baseline_is_about_a_millimetre_on_an_ordinary_take(truth):
    s = score(truth, truth.vertices)
    assert 0.5 < s.frozen.mean() < 1.4
    assert s.strength[s.strongest].min() >= np.percentile(s.strength, 89)


def test_a_shift_is_an_absolute_error_and_no_expression_error(truth):
    shift = Transform(np.eye(3), np.array([0.0, 3.0, 4.0]))
    s = score(truth, truth.vertices, shift @ truth.T_lab_face)
    np.testing.assert_allclose([s.absolute.mean(), s.absolute_p95], 5.0, rtol=1e-6)
    assert s.expression.max() < 1e-9
    assert 0.5 < s.surface < 5.0


def test_another_neutral_is_no_expression_error(truth):
    bulge = np.random.default_rng(0).normal(size=truth.neutral.vertices.shape)
    s = score_vertices(
        lambda frames: truth.vertices(frames) + bulge, truth.neutral.vertices + bulge, truth.T_lab_face, truth
    )
    assert s.expression.max() < 1e-9
    assert s.absolute.mean() > 1


def test_a_performance_is_scored_frame_by_frame(truth):
    face = load_face()
    rig = Rig(truth.neutral, face.rig.deltas, face.rig.names)
    tracked = np.ones(len(truth), dtype=bool)
    performance = Performance(rig, truth.weights, truth.T_lab_face, 30.0, tracked)
    s = score_performance(performance, truth, step=4)
    assert len(s.frames) == len(s.expression) == -(-len(truth) // 4)
    assert 0.05 < s.ratio < 0.6
    frozen_weights = replace(performance, weights=np.zeros_like(truth.weights))
    np.testing.assert_allclose(score_performance(frozen_weights, truth, step=4).expression, s.strength, atol=1e-9)
    assert [row[0] for row in s.rows()][-1] == "expression, strongest tenth"
    assert s.to_dict()["expression_ratio"] == s.ratio


def test_what_cannot_be_compared_is_refused(truth):
    face = load_face()
    short = Performance(face.rig, truth.weights[:9], truth.T_lab_face[:9], 30.0, np.ones(9, dtype=bool))
    with pytest.raises(BadInput, match="frames"):
        score_performance(short, truth)
    with pytest.raises(BadInput, match="neutral"):
        score_vertices(truth.vertices, truth.neutral.vertices[:-1], truth.T_lab_face, truth)
