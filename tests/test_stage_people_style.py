"""How one person makes generic units their own."""

import numpy as np

from mien.faces.bundled import load_face
from mien.stage.people.anatomy import Hinge, jaw_hinge
from mien.stage.people.style import StyleConfig, interactions, jaw_turn, styled_units

NOTHING = StyleConfig(gain=0.0, turn=0.0, extra=0.0, bow=0.0, saturation=0.0, mixing=0.0, pairs=0)


def test_without_style_units_are_the_generic_ones():
    face = load_face()
    hinge = jaw_hinge(face.rig, face.parts["lower_teeth"])
    points = face.rig.neutral.vertices
    units = styled_units(face.rig, points, (hinge, hinge), NOTHING, np.random.default_rng(0))
    np.testing.assert_allclose(units, face.rig.deltas, atol=1e-9)
    assert len(interactions(face.rig.names, units, points, NOTHING, np.random.default_rng(0)).fields) == 0


def test_gaze_and_tongue_are_left_alone_and_the_rest_is_not():
    face = load_face()
    hinge = jaw_hinge(face.rig, face.parts["lower_teeth"])
    config, rng = StyleConfig(), np.random.default_rng(1)
    off = styled_units(face.rig, face.rig.neutral.vertices, (hinge, hinge), config, rng) - face.rig.deltas
    moved = np.abs(off).max(axis=(1, 2))
    alike = np.array([name.startswith(("eyeLook", "tongueOut")) for name in face.rig.names])
    assert moved[alike].max() == 0
    assert moved[~alike].min() > 0


def test_a_point_turns_about_the_hinge_by_rodrigues():
    hinge = Hinge(np.array([0.0, 10.0, -20.0]), 0.3)
    first, second = jaw_turn(np.array([[5.0, 10.0, 30.0]]), hinge)
    moved = np.sin(0.3) * first + (1 - np.cos(0.3)) * second
    np.testing.assert_allclose(np.linalg.norm(moved[0] + [0, 0, 50]), 50.0)
    np.testing.assert_allclose(moved[0, 0], 0.0)
