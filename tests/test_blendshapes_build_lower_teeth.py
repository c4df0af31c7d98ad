"""Teeth behind the skin."""

from dataclasses import replace

import numpy as np
import pytest

from mien.blendshapes.build.lower_teeth import LEAST_MM, lower_teeth_behind_skin, skin_before_teeth, with_arch
from mien.faces import load_face
from mien.fitting.template_parts import TemplateParts
from mien.mesh import Mesh
from mien.rig import Rig


@pytest.fixture(scope="module")
def tight() -> Rig:
    """An open jaw, and a smile that draws the skin below the mouth in by 6 mm, each harmless alone."""
    rig, face = load_face().rig, load_face()
    jaw, smile = rig.deltas[rig.index("jawOpen")], np.zeros_like(rig.neutral.vertices)
    skin = np.zeros(len(smile))
    skin[face.parts["skin"]] = 1
    smile[:, 2] = -6 * skin * np.maximum(face.regions["chin"], face.regions["mouth"])
    return Rig(rig.neutral, np.array([jaw, smile]), ("jawOpen", "mouthSmileLeft"))


def before_teeth(rig: Rig, weights) -> float:
    posed = rig.neutral.vertices + np.tensordot(weights, rig.deltas, axes=1)
    skin = rig.neutral.faces[TemplateParts(load_face()).skin_faces]
    return skin_before_teeth(Mesh(posed, skin), load_face())


def test_two_shapes_that_bring_teeth_through_make_them_smaller(tight):
    assert before_teeth(tight, [1, 0]) > LEAST_MM
    assert before_teeth(tight, [0, 1]) > LEAST_MM
    assert before_teeth(tight, [1, 1]) < 0
    small = lower_teeth_behind_skin(tight, load_face())
    assert before_teeth(small, [1, 1]) >= LEAST_MM
    moved = (small.neutral.vertices != tight.neutral.vertices).any(axis=1)
    inside = np.concatenate([load_face().parts["lower_teeth"], load_face().parts["tongue"]])
    assert set(np.flatnonzero(moved)) <= set(inside)


def test_teeth_that_stay_behind_are_left(tight):
    alone = replace(tight, deltas=tight.deltas[:1], names=tight.names[:1])
    np.testing.assert_array_equal(lower_teeth_behind_skin(alone, load_face()).neutral.vertices, alone.neutral.vertices)


def test_a_smaller_arch_keeps_its_ends_and_its_height():
    face = load_face()
    teeth = face.parts["lower_teeth"]
    before = face.rig.neutral.vertices[teeth]
    after = with_arch(face.rig.neutral.vertices, face, 0.9)[teeth]
    np.testing.assert_allclose(np.ptp(after, axis=0), np.ptp(before, axis=0) * [0.9, 1, 0.9])
    assert after[:, 2].min() == pytest.approx(before[:, 2].min())
