"""What the tracker keeps of a rig."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.landmarks.on_rig import FEATURES
from mien.rig import Rig
from mien.tracking.model import tracking_model


def test_the_front_is_the_rigs_own_and_its_shares_are_one():
    model = stage.model()
    rig = model.rig
    np.testing.assert_allclose(model.neutral, rig.neutral.vertices[model.front], atol=1e-4)
    np.testing.assert_allclose(model.basis, rig.deltas[:, model.front].transpose(1, 2, 0), atol=1e-4)
    assert model.share.sum() == pytest.approx(1, abs=1e-4)
    assert model.share.min() >= 0
    assert model.neutral[:, 2].min() > rig.neutral.vertices[:, 2].min() + 30


def test_features_are_the_landmarks():
    model = stage.model()
    weights = stage.named(model.rig, jawOpen=0.5, mouthSmileLeft=0.4)
    expected = stage.landmarks().attachment.points(model.rig.mesh(weights))[list(FEATURES)]
    np.testing.assert_allclose(model.features(model.blend(weights)), expected, atol=0.1)
    moved = model.landmark_neutral + model.landmark_basis @ weights
    np.testing.assert_allclose(moved[list(FEATURES)], expected, atol=1e-9)


def test_a_displaced_front_ends_at_its_rim():
    model = stage.model()
    weights = stage.named(model.rig, browInnerUp=0.3)
    whole = model.whole(weights, model.rig.vertices(weights)[model.front] + 1.0)
    moved = whole - model.rig.vertices(weights)
    np.testing.assert_allclose(moved[model.front[model.rim]], 0, atol=1e-9)
    np.testing.assert_allclose(moved[model.front[model.fade == 1]], 1.0, atol=1e-9)
    others = np.setdiff1d(np.arange(len(whole)), model.front)
    assert not moved[others].any()


def test_what_cannot_be_tracked_on_is_refused():
    rig, landmarks = stage.person(), stage.landmarks()
    with pytest.raises(BadInput, match="has no shapes"):
        tracking_model(Rig(rig.neutral, rig.deltas[:0], ()), landmarks)
    known = landmarks.known.copy()
    known[FEATURES[3]] = False
    with pytest.raises(BadInput, match="landmarks are not complete"):
        tracking_model(rig, replace(landmarks, known=known))
