"""What cannot be matched."""

from dataclasses import replace

import numpy as np

from blendshape_faces import LAYOUT, face_landmarks, face_map
from mien.blendshapes.correspond.occlusion import behind_lips, inside_loop, openings, polygon, skin, wires, without
from mien.landmarks.detector import LOOPS


def test_a_polygon_is_filled():
    mask = polygon(np.array([[2, 2], [7, 2], [7, 7], [2, 7.0]]), (10, 12))
    assert mask.sum() == 36
    assert not polygon(np.zeros((0, 2)), (4, 4)).any()


def test_an_open_mouth_is_masked_and_a_closed_one_hardly():
    closed = openings(face_map(), face_landmarks().pixels(LAYOUT))
    opened = openings(face_map("jaw", jawOpen=0.7), face_landmarks(jawOpen=0.7).pixels(LAYOUT))
    low = slice(LAYOUT.shape[0] // 2, None)
    assert opened[low].sum() > 3 * closed[low].sum()


def test_a_mouth_of_which_some_landmarks_fell_through_is_masked_all_the_same():
    marks = face_landmarks(jawOpen=0.7).pixels(LAYOUT)
    whole = openings(face_map("jaw", jawOpen=0.7), marks)
    marks[list(LOOPS["lips_inner"])[::4]] = np.nan
    assert (openings(face_map("jaw", jawOpen=0.7), marks) & whole).sum() > 0.9 * whole.sum()
    marks[list(LOOPS["lips_inner"])[1:]] = np.nan
    assert not inside_loop("lips_inner", marks, LAYOUT.shape).any()


def test_teeth_beside_a_loop_that_cuts_corners_are_masked():
    marks = face_landmarks(jawOpen=0.7).pixels(LAYOUT)
    whole = openings(face_map("jaw", jawOpen=0.7), marks)
    lower = list(LOOPS["lips_inner"])[3:8]
    marks[lower] = np.nan
    open_mouth = face_map("jaw", jawOpen=0.7)
    cut = inside_loop("lips_inner", marks, LAYOUT.shape) & whole
    assert (openings(open_mouth, marks) & whole).sum() > 0.95 * whole.sum() > 1.1 * cut.sum()
    closed = behind_lips(face_map(), face_landmarks().pixels(LAYOUT))
    assert closed.sum() < 0.05 * behind_lips(open_mouth, marks).sum()


def test_eyes_holes_and_paint_are_no_skin():
    painted = np.zeros(LAYOUT.shape, bool)
    painted[100:110, 160:170] = True
    free = skin(face_map(), face_landmarks().pixels(LAYOUT), painted)
    iris = np.round(face_landmarks().pixels(LAYOUT)[468]).astype(int)
    assert not free[iris[1], iris[0]]
    assert not free[painted].any()
    assert not free[~face_map().known].any()


def test_rims_before_the_face_are_found_and_a_face_has_none():
    marks = face_landmarks().pixels(LAYOUT)
    assert not wires(face_map(), marks).any()
    row, column = np.round(marks[168, ::-1]).astype(int)
    rim = np.zeros(LAYOUT.shape, bool)
    rim[row - 1 : row + 2, column - 45 : column + 45] = True
    positions = face_map().positions.copy()
    positions[rim] *= [1.15, 1, 1.15]
    worn = replace(face_map(), positions=positions)
    found = wires(worn, marks)
    assert found[rim].mean() > 0.9
    assert found.sum() < 2.5 * rim.sum()
    assert not without(worn, found).known[rim & found].any()


def test_a_map_without_pixels_knows_nothing_there():
    gone = np.zeros(LAYOUT.shape, bool)
    gone[100:110] = True
    left = without(face_map(), gone)
    assert not left.known[100:110].any()
    assert (left.confidence[100:110] == 0).all()
    np.testing.assert_array_equal(left.known[:100], face_map().known[:100])
