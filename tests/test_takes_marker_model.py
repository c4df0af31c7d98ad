"""Where a rig puts the markers."""

import numpy as np

from marker_stage import held, small_model
from mien.faces import load_face
from mien.takes.marker_model import marker_model
from mien.transforms import Transform, rotation_from_vector


def test_jacobian_is_the_derivative_of_the_posed_points():
    model = small_model()
    A, h = model.jacobian(), 1e-6
    for column in range(A.shape[2]):
        x = np.zeros(A.shape[2])
        x[column] = h
        posed = Transform(rotation_from_vector(x[6:9]), x[9:]).apply(model.points(x[:6]))
        np.testing.assert_allclose((posed - model.neutral) / h, A[..., column], atol=1e-3)


def test_marker_model_stands_off_along_the_normal():
    face = load_face()
    places = held()
    on, off = (marker_model(face.rig, places, np.full(60, s)) for s in (0.0, 3.0))
    np.testing.assert_allclose(np.linalg.norm(off.neutral - on.neutral, axis=1), 3, atol=1e-9)
    moved = np.stack([places.matrix(face.rig.neutral) @ d for d in face.rig.deltas])
    np.testing.assert_allclose(on.shapes, moved, atol=1e-9)
