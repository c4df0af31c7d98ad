"""Markers on a face, their places given."""

import numpy as np

from marker_stage import held
from mien.faces import load_face
from mien.fitting.terms import surface_points
from mien.markers.calibrate import calibrate_by_hand
from mien.transforms import Transform, rotation_from_vector


def test_person_pose_and_neutral_are_found_from_places_by_hand():
    """Somebody of the identity space who opens and shuts their jaw, seen from a head frame elsewhere."""
    face = load_face()
    someone = face.person(0.7 * np.random.default_rng(8).normal(size=len(face.identity.modes)))
    jaw = np.clip(np.sin(np.arange(60) / 6.0), 0, None)
    weights = np.zeros((60, len(someone.names)))
    weights[:, someone.index("jawOpen")] = 0.6 * jaw
    T_head_face = Transform(rotation_from_vector(np.array([0.3, -0.2, 0.1])), np.array([10.0, 50.0, -20.0]))
    worn = [surface_points(someone.mesh(w), held(), 2.0) for w in weights]
    positions = T_head_face.apply(np.stack(worn))
    found = calibrate_by_hand(positions, face, held())
    assert jaw[found.neutral.frame] < 0.1
    assert found.shape_mm < 0.9
    both = (found.T_face_head @ T_head_face).apply(someone.neutral.vertices) - someone.neutral.vertices
    assert np.linalg.norm(both, axis=1).mean() < 2.0
    np.testing.assert_array_equal(found.kept, np.arange(60))
    points = surface_points(found.rig.neutral, found.attachment, float(found.standoff[0]))
    assert np.linalg.norm(points - found.neutral_markers, axis=1).mean() < 0.9
