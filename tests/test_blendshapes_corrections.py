"""Landmarks and masks by hand."""

import json

import numpy as np
import pytest
from PIL import Image

from blendshape_faces import LAYOUT, face_landmarks, face_map
from mien.blendshapes import corrections
from mien.blendshapes.corrections import (
    Correction,
    check_names,
    landmarks_by_hand,
    pinned,
    pins_by_hand,
    read_corrections,
    without_painted,
)
from mien.errors import BadInput

CORNER = 61


def written(folder, told) -> str:
    (folder / "corrections.json").write_text(json.dumps(told))
    return str(folder / "corrections.json")


def test_a_file_is_read(tmp_path):
    picture = np.full((4, 6, 3), 200, np.uint8)
    picture[1, 2] = 0
    Image.fromarray(picture).save(tmp_path / "smile.png")
    told = {
        "smile": {"landmarks": {"61": [212, 340.5], "13": None}, "mask": "smile.png"},
        "neutral": {"pins": {"mole": [3, 4]}},
    }
    found = read_corrections(written(tmp_path, told))
    assert found["smile"].landmarks == {61: (212.0, 340.5), 13: None}
    assert found["smile"].painted is not None
    np.testing.assert_array_equal(np.argwhere(found["smile"].painted), [[1, 2]])
    assert found["neutral"].painted is None
    assert found["neutral"].pins == {"mole": (3.0, 4.0)}


@pytest.mark.parametrize(
    ("told", "why"),
    [
        ({"smile": {"landmark": {}}}, "unknown: landmark"),
        ({"smile": {"landmarks": {"478": [1, 2]}}}, "there are 478"),
        ({"smile": {"landmarks": {"lip": [1, 2]}}}, "is not"),
        ({"smile": {"landmarks": {"61": 3}}}, "is not"),
        ([1], "is not"),
        ({"smile": {"mask": "none.png"}}, r"none\.png"),
    ],
)
def test_a_damaged_file_is_one_line(tmp_path, told, why):
    with pytest.raises(BadInput, match=why) as error:
        read_corrections(written(tmp_path, told))
    assert "\n" not in str(error.value)


def test_a_correction_of_no_capture_is_named():
    check_names(["smile"], ["smile", "neutral"])
    with pytest.raises(BadInput, match="corrections of grin"):
        check_names(["grin"], ["smile", "neutral"])


def test_what_is_painted_out_is_gone_from_the_map():
    map_ = face_map()
    painted = np.zeros(LAYOUT.shape, bool)
    painted[100:110, 150:170] = True
    left = without_painted(map_, Correction(painted=painted))
    np.testing.assert_array_equal(left.known, map_.known & ~painted)
    assert (left.confidence[painted] == 0).all()
    with pytest.raises(BadInput, match=r"mask of neutral: is 3 x 2 pixels"):
        without_painted(map_, Correction(painted=np.zeros((2, 3), bool)))


def test_landmarks_are_moved_and_dropped(monkeypatch):
    monkeypatch.setattr(corrections, "landmarks_on_map", lambda _: face_landmarks())
    place = face_landmarks().pixels(LAYOUT)[CORNER] + [3.0, 0.0]
    found = landmarks_by_hand(face_map(), Correction({CORNER: tuple(place), 13: None}))
    np.testing.assert_allclose(found.pixels(LAYOUT)[CORNER], place, atol=0.2)
    assert not found.known[13]
    np.testing.assert_array_equal(found.points[14], face_landmarks().points[14])
    with pytest.raises(BadInput, match="shows nothing there"):
        landmarks_by_hand(face_map(), Correction({CORNER: (0.0, 0.0)}))


def test_a_face_that_is_not_found_may_be_marked_by_hand(monkeypatch):
    def nothing(_):
        raise BadInput("no face")

    monkeypatch.setattr(corrections, "landmarks_on_map", nothing)
    with pytest.raises(BadInput, match="no face"):
        landmarks_by_hand(face_map())
    places = {i: tuple(p) for i, p in enumerate(face_landmarks().pixels(LAYOUT)[:10])}
    assert landmarks_by_hand(face_map(), Correction(places)).known.sum() == 10


def test_pins_that_both_captures_have_hold_the_warp():
    calm, open_ = face_map(), face_map("jawOpen", jawOpen=0.7)
    here = pins_by_hand(calm, Correction(pins={"mole": (150.0, 100.0), "scar": (120.0, 90.0)}))
    there = pins_by_hand(open_, Correction(pins={"mole": (153.0, 104.0), "freckle": (140.0, 90.0)}))
    held = pinned(here, there, LAYOUT)
    np.testing.assert_allclose([held.source, held.target], [[[150, 100]], [[153, 104]]], atol=0.05)
    assert pinned(here, {}, LAYOUT) is None
    with pytest.raises(BadInput, match=r"pin mole at .* shows nothing"):
        pins_by_hand(calm, Correction(pins={"mole": (0.0, 259.0)}))
