import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.fitting.scan_landmarks import believed, on_brow_edges
from mien.landmarks.detector import bundled_landmarks
from mien.register.nonrigid import Anchors


def test_brows_go_to_the_nearest_of_their_edge_and_beyond_its_ends_nowhere():
    mesh, at = load_face().rig.neutral, bundled_landmarks().attachment
    points = at.points(mesh)
    inner = np.concatenate([np.linspace(points[a], points[b], 100) for a, b in ((66, 105), (105, 63))])
    edges = np.stack([inner + np.array([0.0, 2.0, 0.0]), np.full_like(inner, np.nan)])
    anchors, brows = on_brow_edges(Anchors(at, points, np.ones(len(points))), mesh, edges, 0.3)
    assert brows == ("brow_right",)
    assert anchors.weights[105] == pytest.approx(0.3)
    assert not anchors.weights[[107, 70, 52, 46]].any()
    assert anchors.weights[bundled_landmarks().groups["brow_left"]].all()
    assert 1.0 < anchors.points[105, 1] - points[105, 1] < 2.5


def test_a_landmark_far_from_the_fitted_face_counts_less():
    face = load_face()
    at = bundled_landmarks().attachment
    points = at.points(face.rig.neutral)
    points[7] += [0.0, 0.0, 4.0]
    weights = believed(Anchors(at, points, np.ones(len(points))), face.rig.neutral, 4.0).weights
    assert weights[7] == pytest.approx(0.25)
    np.testing.assert_allclose(np.delete(weights, 7), 1.0)
