"""Motion of skin, told by that of markers."""

import numpy as np
import pytest

from marker_stage import held
from mien.faces import load_face
from mien.takes.motion_covariance import CovarianceConfig, motion_covariance


@pytest.fixture(scope="module")
def carried():
    """Sixty markers on the bundled face, and the covariance of its skin with them."""
    face, places = load_face(), held()
    return face, places, motion_covariance(face.rig, places, face.parts["skin"])


def motions(face, places, weights):
    """Markers' motion under the bundled shapes, (t, 3 markers)."""
    at_markers = np.stack([places.matrix(face.rig.neutral) @ d for d in face.rig.deltas])
    return np.einsum("tk,kma->tma", weights, at_markers).reshape(len(weights), -1)


def test_markers_are_met_but_for_their_noise(carried):
    face, places, covariance = carried
    motion = motions(face, places, np.random.default_rng(1).uniform(0, 0.4, (5, 52)))
    carry = covariance.carry(np.arange(60))
    skin = np.einsum("vac,tc->tva", carry, motion)
    met = np.stack([places.matrix(face.rig.neutral) @ x for x in skin])
    assert np.linalg.norm(met - motion.reshape(met.shape), axis=2).mean() < 0.1


def test_a_marker_that_is_not_shown_is_told_by_those_that_are(carried):
    face, places, covariance = carried
    motion = motions(face, places, np.random.default_rng(2).uniform(0, 0.4, (20, 52)))
    hidden, shown = np.arange(0, 60, 6), np.setdiff1d(np.arange(60), np.arange(0, 60, 6))
    there = motion.reshape(20, 60, 3)
    spline = motion_covariance(face.rig, places, face.parts["skin"], CovarianceConfig(shape_deviation=1e-6))
    error = []
    for known in (covariance, spline):
        told = np.einsum("hac,tc->tha", known.carry(shown, hidden), there[:, shown].reshape(20, -1))
        error.append(np.linalg.norm(told - there[:, hidden], axis=2).mean())
    assert error[0] < 0.75 * np.linalg.norm(there[:, hidden], axis=2).mean()
    assert error[0] < error[1]


def test_the_upper_lip_does_not_follow_the_lower_one(carried):
    """What a spline through the air would get wrong: an open jaw leaves the upper lip."""
    face, places, covariance = carried
    jaw = face.rig.index("jawOpen")
    weights = np.eye(52)[[jaw]]
    skin = np.einsum("vac,tc->tva", covariance.carry(np.arange(60)), motions(face, places, weights))[0]
    moved = np.linalg.norm(face.rig.deltas[jaw], axis=1)
    chin = face.parts["skin"][np.argmax(moved[face.parts["skin"]])]
    nose = face.parts["skin"][np.argmax(face.rig.neutral.vertices[face.parts["skin"], 2])]
    assert np.linalg.norm(skin[chin] - face.rig.deltas[jaw][chin]) < 0.3 * moved[chin]
    assert np.linalg.norm(skin[nose]) < 0.1 * moved[chin]
