"""Captures to a rig."""

from dataclasses import replace

import numpy as np
import pytest

from blendshape_faces import LAYOUT, face_map
from blendshape_rig import JAW, QUICK, SMILE, built_rig, true_landmarks
from mien.blendshapes import corrections, expression, pipeline
from mien.blendshapes.captures import Capture
from mien.blendshapes.corrections import Correction, pins_by_hand
from mien.blendshapes.expression import build_shape
from mien.faces import ARKIT_NAMES, load_face


@pytest.fixture(scope="module")
def built():
    return built_rig()


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


def test_corrections_by_hand_go_to_their_captures_and_a_bad_one_leaves_its_own_out(monkeypatch):
    seen = {}

    def noted(made):
        def step(map_, *_, by_hand, **__):
            seen[map_.name] = (map_.known.sum(), by_hand)
            return made

        return step

    monkeypatch.setattr(pipeline, "neutral_face", noted(built_rig().neutral))
    monkeypatch.setattr(pipeline, "build_shape", noted(built_rig().shapes[0]))
    textured = built_rig().textured
    monkeypatch.setattr(pipeline, "with_masks", lambda *_: textured)
    captures = [Capture(face_map(name), "") for name in ("neutral", "jawOpen", "grin", "frown")]
    painted = np.zeros(LAYOUT.shape, bool)
    painted[100:110, 150:170] = True
    moved = Correction({61: (150.0, 200.0)})
    by_hand = {"jawOpen": moved, "neutral": Correction(painted=painted), "frown": Correction(painted=painted[:5])}
    made = pipeline.build_rig(captures, "neutral", load_face(), corrections=by_hand)
    assert seen["jawOpen"][1] is moved
    assert seen["neutral"][0] < seen["grin"][0]
    assert [line for line in made.left_out if "mask of frown" in line]


def test_pins_reach_the_warp_in_the_neutrals_frame(monkeypatch):
    class Warped(Exception):
        pass

    def warp(**given):
        held.append(given["pinned"])
        raise Warped

    held, mole = [], Correction(pins={"mole": (150.0, 60.0)})
    neutral = built_rig().neutral
    neutral = replace(neutral, pins=pins_by_hand(neutral.map, mole))
    monkeypatch.setattr(corrections, "landmarks_on_map", true_landmarks)
    monkeypatch.setattr(expression, "warp", warp)
    with pytest.raises(Warped):
        build_shape(face_map("jawOpen", **JAW), neutral, load_face(), replace(QUICK, model=False), mole)
    np.testing.assert_allclose([held[0].source, held[0].target], [[[150, 60]], [[150, 60]]], atol=1.0)
