"""What of the bundled face a scan can show, and what goes along."""

import numpy as np

from mien.faces.bundled import load_face
from mien.fitting.template_parts import TemplateParts, extrapolate_hidden, move_rigid_parts
from mien.mesh import Mesh
from mien.register import Template
from small_scans import bundled_template


def test_hidden_skin_goes_with_what_is_shown():
    """Everything shown moves forward by 5 mm: so does the inside of the mouth."""
    face = load_face()
    body = TemplateParts(face)
    rest = face.rig.neutral.vertices[body.skin]
    shown = body.trust[body.skin] > 0
    moved = np.where(shown[:, None], rest + np.array([0.0, 0, 5]), rest)
    after = extrapolate_hidden(Template(Mesh(rest, body.skin_triangles)), moved, shown)
    np.testing.assert_array_equal(after[shown], moved[shown])
    assert np.abs(after - rest - np.array([0.0, 0, 5])).max() < 0.5


def test_the_lower_lips_lining_goes_with_the_lower_lip_when_the_jaw_opens():
    template, rig = bundled_template(), load_face().rig
    rest, shown = template.skin.vertices, template.shown
    opened = rest + rig.deltas[rig.index("jawOpen")][template.members]
    given = np.where(shown[:, None], opened, rest)
    lining = ~shown & (np.linalg.norm(rest - rest[template.sides == -1].mean(axis=0), axis=1) < 20)
    errors = []
    for sides in (None, template.sides):
        found = extrapolate_hidden(template.body, given, shown, sides)
        errors.append(np.linalg.norm(found - opened, axis=1)[lining].mean())
    blind, sided = errors
    assert np.linalg.norm(opened - rest, axis=1)[lining].mean() > 5
    assert sided < 0.65 * blind


def test_openings_are_hidden_and_the_face_is_shown():
    face = load_face()
    trust = TemplateParts(face).trust
    assert (trust[face.regions["face"] > 0.9] > 0).mean() > 0.97
    assert not trust[face.parts["tongue"]].any()
    assert (trust[face.parts["skin"]] == 0).sum() > 300


def test_an_eye_rides_on_the_skin_round_it():
    face = load_face()
    before = face.rig.neutral.vertices
    skin = face.parts["skin"]
    after = before.copy()
    after[skin] += [0.0, 2.0, -1.0]
    found = move_rigid_parts(face.parts, skin, np.ones(len(skin), bool), before, after)
    np.testing.assert_allclose(found, before + np.array([0.0, 2.0, -1.0]), atol=1e-6)
