"""A rig on another mesh than the bundled one."""

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from blendshape_faces import LAYOUT, face_landmarks, face_map, face_mesh
from blendshape_rig import JAW, QUICK, SEEN, true_landmarks
from mien.blendshapes import corrections
from mien.blendshapes.build.artist_mesh import on_map
from mien.blendshapes.build.own_mesh import inwards, own_mesh, parted, thinned
from mien.blendshapes.captures import Capture
from mien.blendshapes.expression import AUTO
from mien.blendshapes.pipeline import build_rig
from mien.errors import BadInput
from mien.faces import ARKIT_NAMES, load_face
from mien.fitting.template_parts import TemplateParts
from mien.mesh import ClosestPoint, face_areas

TRIANGLES = 2500


@pytest.fixture(scope="module")
def thin():
    return thinned(face_map(), face_landmarks(), TRIANGLES)


def near(points, loop_middle, reach):
    return np.linalg.norm(points - loop_middle, axis=1) < reach


def test_the_neutral_is_thinned_with_small_triangles_at_mouth_and_eyes(thin):
    assert TRIANGLES * 0.95 < len(thin.faces) <= TRIANGLES
    assert np.quantile(ClosestPoint(face_mesh()).query(thin.vertices).distances, 0.9) < 1.0
    areas, centres = face_areas(thin.vertices, thin.faces), thin.vertices[thin.faces].mean(1)
    marks = face_landmarks().points
    mouth, eye = marks[[61, 291]].mean(0), marks[[33, 133]].mean(0)
    brow_free = marks[151] + [0, 15, 0]
    calm = np.median(areas[near(centres, brow_free, 20)])
    assert np.median(areas[near(centres, mouth, 15)]) < 0.5 * calm
    assert np.median(areas[near(centres, eye, 12)]) < 0.5 * calm


def test_its_uv_are_the_cylinders(thin):
    height, width = LAYOUT.shape
    places = np.stack([thin.uv[:, 0] * width - 0.5, (1 - thin.uv[:, 1]) * height - 0.5], 1)
    np.testing.assert_allclose(places, LAYOUT.pixels(thin.vertices), atol=1e-9)


def test_lips_are_cut_apart_between_the_corners():
    mesh = face_mesh()
    cut = parted(replace(mesh, uv=None, uv_faces=None, colors=None), face_landmarks())
    doubled = cut.vertices[len(mesh.vertices) :]
    line = face_landmarks().points[[78, 308]]
    assert len(doubled) > 3
    assert (doubled[:, 0] > line[0, 0] - 3).all()
    assert (doubled[:, 0] < line[1, 0] + 3).all()
    assert np.abs(doubled[:, 1] - line[:, 1].mean()).max() < 8


def test_a_rig_on_the_thinned_neutral_has_the_captures_and_all_52():
    captures = [Capture(face_map(name, **weights), "") for name, weights in SEEN.items()]
    config = replace(QUICK, triangles=TRIANGLES)
    with patch.object(corrections, "landmarks_on_map", true_landmarks):
        built = build_rig(captures, "neutral", load_face(), True, config, on=AUTO)
    rig = built.textured.rig
    assert rig.names == (*ARKIT_NAMES, "grin")
    at = ClosestPoint(face_mesh()).query(rig.neutral.vertices).attachment()
    true = at.points(face_mesh(**JAW)) - at.points(face_mesh())
    shown = built.neutral.own.artist.shown
    off = np.linalg.norm(rig.deltas[rig.index("jawOpen")] - true, axis=1)[shown]
    assert np.median(off) < 0.5
    blink = rig.deltas[rig.index("eyeBlinkLeft")]
    assert np.abs(blink).max() > 4
    assert built.textured.textures.shape[1:] == (QUICK.texture, QUICK.texture, 3)
    assert built.left_out == ()


def test_both_sides_of_the_cut_follow_their_own_lip():
    mesh, marks = face_mesh(), face_landmarks()
    cut = parted(replace(mesh, uv=None, uv_faces=None, colors=None), marks)
    n, doubled = len(mesh.vertices), len(cut.vertices) - len(mesh.vertices)
    moved = inwards(cut)
    lower = moved[n:]
    upper = moved[[np.flatnonzero((mesh.vertices == v).all(1))[0] for v in cut.vertices[n:]]]
    assert (upper[:, 1] - lower[:, 1] > 0.1).mean() > 0.7, doubled


def test_a_mesh_that_lies_elsewhere_or_has_no_uv_is_refused(thin):
    face = load_face()
    skin = TemplateParts(face).skin_faces
    bundled = on_map(face_mesh(), face_map())
    with pytest.raises(BadInput, match="lie on the neutral scan"):
        own_mesh(thin.with_vertices(thin.vertices + 40.0), face_map(), bundled, skin)
    with pytest.raises(BadInput, match="no texture coordinates"):
        own_mesh(replace(thin, uv=None), face_map(), bundled, skin)
