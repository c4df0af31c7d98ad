"""Landmarks of several views as one."""

import numpy as np

from face_model import needs_model
from mien.faces.bundled import load_face
from mien.landmarks.detector import bundled_landmarks
from mien.landmarks.lift import similarity_to_average
from mien.transforms import Transform, rotation_from_vector

pytestmark = needs_model


def test_similarity_ignores_a_few_bad_landmarks():
    truth = bundled_landmarks().attachment.points(load_face().rig.neutral)
    T = Transform(rotation_from_vector(np.array([0.2, -0.4, 1.0])), np.array([5.0, 6, 7]), 0.01)
    points = T.apply(truth)
    rng = np.random.default_rng(0)
    points[rng.random(478) < 0.1] += 0.5
    points[rng.random(478) < 0.1] = np.nan
    found, misfit = similarity_to_average(points)
    np.testing.assert_allclose((found @ T).apply(truth), truth, atol=1e-6)
    assert misfit < 1e-6
    assert similarity_to_average(np.full((478, 3), np.nan))[1] == np.inf
