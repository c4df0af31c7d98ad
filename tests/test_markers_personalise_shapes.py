"""Shapes bent to the performer."""

import numpy as np

from marker_stage import held, small_model
from mien.faces import load_face
from mien.markers.personalise_shapes import PersonaliseConfig, personalise_shapes, shape_corrections, spline
from mien.takes.marker_model import MarkerModel


def test_corrections_recover_a_performers_bent_shapes():
    model = small_model()
    rng = np.random.default_rng(13)
    W = np.clip(rng.normal(0.2, 0.4, size=(800, 6)), 0, 1)
    bent = MarkerModel(model.neutral, model.shapes * (1 + 0.3 * rng.normal(size=(6, 40, 1))))
    targets = bent.points(W) + 0.05 * rng.normal(size=(800, 40, 3))
    used = rng.random((800, 40)) < 0.9
    neutral, shapes = shape_corrections(model, W, targets, used, 8.0)
    np.testing.assert_allclose(model.shapes + shapes, bent.shapes, atol=0.15)
    np.testing.assert_allclose(neutral, 0, atol=0.1)


def test_spread_interpolates_smoothly_and_stays_on_the_skin():
    face = load_face()
    places = held()
    skin = face.parts["skin"]
    S = spline(face.rig.neutral, places, skin)
    smooth = places.points(face.rig.neutral)[:, 1] / 50
    at_markers = places.matrix(face.rig.neutral) @ (S @ smooth)
    np.testing.assert_allclose(at_markers, smooth, atol=0.05)
    assert not S[face.parts["left_eye"]].any()
    back = np.argmin(face.rig.neutral.vertices[:, 2])
    assert np.abs(S[back]).max() < 0.05


def test_bent_rig_meets_the_corrections_and_leaves_still_shapes_still():
    face = load_face()
    places = held()
    field = np.tile(np.random.default_rng(14).normal(size=3), (60, 1))
    S = spline(face.rig.neutral, places, face.parts["skin"])
    corrections = 0.2 * np.stack([places.matrix(face.rig.neutral) @ d for d in face.rig.deltas])
    bent = personalise_shapes(face.rig, places, field, corrections, S, PersonaliseConfig())
    np.testing.assert_allclose(places.points(bent.neutral) - places.points(face.rig.neutral), field, atol=0.15)
    smile = face.rig.index("mouthSmileLeft")
    D = places.matrix(face.rig.neutral)
    wanted = 1.2 * (D @ face.rig.deltas[smile])
    assert np.abs(D @ bent.deltas[smile] - wanted).max() < 0.35 * np.abs(0.2 * wanted).max()
    look = face.rig.index("eyeLookUpLeft")
    ball = face.parts["left_eye"]
    np.testing.assert_array_equal(bent.deltas[look][ball], face.rig.deltas[look][ball])
