"""The prior of coefficients: twins, opposites, and what scores do to the equations, by hand."""

from dataclasses import replace

import numpy as np

from mien.faces.arkit import ARKIT_NAMES
from mien.tracking.terms.fit_config import BlendshapeFitConfig
from mien.tracking.terms.weight_prior import (
    DEAREST,
    SCORE_DEVIATIONS,
    add_priors,
    dearer_where_idle,
    twin,
    weight_prior,
)

NAMES = ("mouthSmileLeft", "mouthSmileRight", "mouthLeft", "mouthRight", "noseSneerLeft")
NOTHING = BlendshapeFitConfig(
    ridge=0.0, l1=0.0, l1_per_mm=0.0, temporal_weight=0.0, scores=0.0, symmetry=0.0, opposition=0.0
)


def equations(x, said=None, **config):
    A, b = np.zeros((11, 11)), np.zeros(11)
    settings = replace(NOTHING, **config)
    add_priors(A, b, x, np.zeros(5), said, weight_prior(NAMES), np.ones(5), settings)
    return A[:5, :5], b[:5]


def test_twins():
    assert twin("mouthSmileLeft") == "mouthSmileRight"
    assert twin("eyeLookInLeft") == "eyeLookOutRight"
    assert [twin(name) for name in ("mouthLeft", "mouthSmileRight", "jawOpen")] == [None] * 3
    assert sum(twin(name) is not None for name in ARKIT_NAMES) == 18


def test_the_two_sides_draw_each_other():
    A, b = equations(np.array([1.0, 0, 0, 0, 0]), symmetry=2.0)
    np.testing.assert_allclose(A[:2, :2], [[2, -2], [-2, 2]])
    np.testing.assert_allclose(b, [-2, 2, 0, 0, 0])


def test_opposites_push_each_other_away():
    _, b = equations(np.array([0, 0, 0.5, 0.25, 0]), opposition=4.0)
    np.testing.assert_allclose(b, [0, 0, -1, -2, 0])


def test_scores_count_by_their_variance_and_not_where_they_say_nothing():
    scores = np.array([0.5, np.nan, 0.5, 0.5, 0.5])
    A, b = equations(np.zeros(5), scores, scores=3.0)
    trust = 3.0 / SCORE_DEVIATIONS["mouthSmile"] ** 2
    np.testing.assert_allclose(np.diag(A), [trust, 0, 0, 0, 0])
    np.testing.assert_allclose(b, [trust / 2, 0, 0, 0, 0])


def test_lids_and_gaze_are_listened_to_more():
    prior = weight_prior(("eyeBlinkLeft", "eyeLookUpLeft", "jawOpen"))
    np.testing.assert_array_equal(prior.small_in_depth, [1, 1, 0])


def test_ridge_sparsity_and_stillness_by_hand():
    x = np.array([0.5, 0, 0, 0, 0])
    A, b = equations(x, ridge=1.0, temporal_weight=2.0, l1=3.0, reweight_eps=0.5)
    np.testing.assert_allclose(np.diag(A), 3.0)
    np.testing.assert_allclose(b, [-3 * 0.5 - 3 / 2 / 2, -1.5, -1.5, -1.5, -1.5])


def test_what_a_take_hardly_uses_grows_dearer_by_hand():
    """Used at 0.5 in a quarter of the frames: 0.25 root mean square, so that 0.5 doubles its price."""
    weights = np.zeros((4, 5))
    weights[0] = [0.5, 1.0, 2.0, 0.002, 0.0]
    prior = dearer_where_idle(weight_prior(NAMES), weights, in_use=0.5)
    np.testing.assert_allclose(prior.dearness, [2, 1, 1, DEAREST, DEAREST])
    np.testing.assert_array_equal(dearer_where_idle(prior, weights, in_use=0.0).dearness, np.ones(5))


def test_what_a_long_take_shows_once_stays_as_it_is():
    """A wink at full weight for a second and a half of a quarter of an hour."""
    weights = np.zeros((27_000, 5))
    weights[9_000:9_045] = 1.0
    prior = dearer_where_idle(weight_prior(NAMES), weights, in_use=0.5)
    np.testing.assert_array_equal(prior.dearness, np.ones(5))


def test_the_dearer_coefficient_pays_so_many_times_the_price():
    A, b = np.zeros((11, 11)), np.zeros(11)
    prior = replace(weight_prior(NAMES), dearness=np.array([1.0, 2, 1, 1, 6]))
    add_priors(A, b, np.zeros(5), np.zeros(5), None, prior, np.ones(5), replace(NOTHING, l1=2.0, l1_per_mm=1.0))
    np.testing.assert_allclose(b[:5], [-1.5, -3, -1.5, -1.5, -9])
    np.testing.assert_array_equal(A, 0)
