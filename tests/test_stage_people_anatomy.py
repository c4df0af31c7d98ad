"""Hinge, balls and edges of a face."""

import numpy as np

from mien.faces.bundled import load_face
from mien.stage.people.anatomy import eyeball, jaw_hinge, lid_contact, lip_contact, rigid_motion
from mien.transforms import rotation_from_vector


def test_rigid_motion_undoes_a_known_one():
    points = np.random.default_rng(1).normal(size=(20, 3))
    R = rotation_from_vector(np.array([0.3, -0.2, 0.5]))
    found, t = rigid_motion(points, points @ R.T + [1.0, 2.0, 3.0])
    np.testing.assert_allclose(found, R, atol=1e-12)
    np.testing.assert_allclose(t, [1.0, 2.0, 3.0], atol=1e-12)


def skin():
    return load_face().on_skin


def test_the_jaw_turns_about_an_axis_behind_the_mouth():
    face = load_face()
    hinge = jaw_hinge(face.rig, face.parts["lower_teeth"])
    teeth = face.rig.neutral.vertices[face.parts["lower_teeth"]].mean(axis=0)
    assert 0.1 < abs(hinge.angle) < 0.7
    assert hinge.centre[2] < teeth[2] - 30


def test_an_eye_is_a_ball_of_an_eyes_size():
    face = load_face()
    left, right = (eyeball(face, face.rig.neutral.vertices, side) for side in ("Left", "Right"))
    assert 12 < left.radius < 18
    np.testing.assert_allclose(left.centre * [-1, 1, 1], right.centre, atol=0.5)


def test_partners_on_lids_and_lips_stand_above_one_another():
    face = load_face()
    ball = eyeball(face, face.rig.neutral.vertices, "Left")
    for contact in (lid_contact(face, ball, "Left", skin()), lip_contact(face, skin())):
        upper, lower = contact.points(face.rig.neutral.vertices)
        assert upper.shape == lower.shape
        assert np.median(upper[:, 1] - lower[:, 1]) > -0.5
