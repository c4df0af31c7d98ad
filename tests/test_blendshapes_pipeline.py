"""Captures to a rig."""

import numpy as np
import pytest

from blendshape_faces import face_landmarks, face_map
from mien.blendshapes import expression
from mien.blendshapes.captures import Capture
from mien.blendshapes.correspond.landmarks import MapLandmarks
from mien.blendshapes.expression import RigConfig
from mien.blendshapes.pipeline import build_rig
from mien.faces import ARKIT_NAMES, load_face

JAW, SMILE = {"jawOpen": 0.7}, {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9}
SEEN = {"neutral": {}, "jawOpen": JAW, "grin": SMILE}


@pytest.fixture(scope="module")
def built():
    def landmarks(map_):
        if map_.name == "blind":
            return MapLandmarks(face_landmarks().points, np.zeros(478, bool))
        return face_landmarks(**SEEN[map_.name])

    patch = pytest.MonkeyPatch()
    patch.setattr(expression, "landmarks_on_map", landmarks)
    captures = [Capture(face_map(name, **weights), "") for name, weights in SEEN.items()]
    captures.append(Capture(face_map("blind"), ""))
    yield build_rig(captures, "neutral", load_face(), True, RigConfig(texture=128))
    patch.undo()


def test_a_capture_that_cannot_be_used_is_named_and_left_out(built):
    assert [shape.name for shape in built.shapes] == ["jawOpen", "grin"]
    assert "blind" in built.left_out[0]


def test_shapes_are_the_captures_in_correspondence(built):
    rig, face = built.textured.rig, load_face()
    assert rig.names == (*ARKIT_NAMES, "grin")
    front = face.regions["narrow"] > 0.5
    wanted = 0.7 * face.rig.deltas[face.rig.index("jawOpen")]
    off = np.linalg.norm(rig.deltas[rig.index("jawOpen")] - wanted, axis=1)[front]
    assert np.median(off) < 0.5
    assert off.mean() < 0.15 * np.linalg.norm(wanted, axis=1).max()


def test_textures_go_with_the_shapes(built):
    textured = built.textured
    assert textured.captures == ("jawOpen", "grin")
    assert textured.regions[0] == ("lower",)
    drift = np.abs(textured.textures[0].astype(float) - textured.rig.texture)[textured.mask(0) > 0.5]
    assert np.median(drift) < 8
    grin = textured.mixes[1]
    assert min(grin[textured.rig.index(name)] for name in SMILE) > 0.3
