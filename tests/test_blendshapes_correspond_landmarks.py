"""Landmarks on maps."""

from dataclasses import replace

import numpy as np

from blendshape_faces import LAYOUT, face_landmarks, face_mesh
from mien.blendshapes.correspond.landmarks import ACROSS, EDGES, along_contours, common_landmarks, mouth_opening, opened
from mien.faces import load_face
from mien.landmarks.detector import bundled_landmarks


def test_only_landmarks_of_both_scans_that_keep_to_the_skin_count():
    calm, other = face_landmarks(), face_landmarks(jawOpen=0.5).edited({1: None})
    common = common_landmarks(calm, other)
    assert not common[1]
    assert not common[bundled_landmarks().groups["iris_left"]].any()
    assert common.sum() == len(bundled_landmarks().stable) - 1


def test_by_hand_landmarks_are_moved_added_and_dropped():
    edited = face_landmarks().edited({5: None}).edited({5: np.ones(3), 7: np.zeros(3)})
    assert edited.known[5]
    np.testing.assert_array_equal(edited.points[[5, 7]], [[1, 1, 1], [0, 0, 0]])


def test_crossed_lips_are_put_right():
    pixels = face_landmarks().pixels(LAYOUT).copy()
    upper, lower = ACROSS[3]
    pixels[[upper, lower]] = pixels[[lower, upper]] + [[0, 3], [0, -3]]
    fixed = opened(pixels)
    assert all(fixed[b, 1] - fixed[a, 1] >= 0.5 - 1e-9 for a, b in ACROSS)


def test_a_mouth_opens_by_its_widest_pair():
    calm, jaw = (face_landmarks(jawOpen=w).pixels(LAYOUT) for w in (0.0, 0.7))
    assert mouth_opening(calm, calm) == 0
    assert mouth_opening(calm, jaw) == 0
    upper, lower = ACROSS[4]
    middle = (jaw - calm)[lower, 1] - (jaw - calm)[upper, 1]
    assert mouth_opening(jaw, calm) >= middle > 10
    assert mouth_opening(np.full_like(jaw, np.nan), calm) == 0


def test_pairs_face_each_other_and_edges_lie_on_their_contours():
    points = face_landmarks(jawOpen=0.6).points
    assert all(points[upper, 1] > points[lower, 1] for upper, lower in ACROSS[:9])
    face = load_face()
    for name, ids in EDGES.items():
        contour = face.rig.neutral.vertices[face.contours[name]]
        off = np.linalg.norm(face_landmarks().points[list(ids)][:, None] - contour, axis=2).min(1)
        assert np.median(off) < 4, name


def test_lips_follow_their_landmarks():
    face = load_face()
    moved = along_contours(face_mesh().vertices, face.contours, face_landmarks(jawOpen=0.6), face_landmarks())
    true = face_mesh(jawOpen=0.6).vertices - face_mesh().vertices
    lip = face.contours["lower_lip"]
    assert np.abs(moved[lip] - true[lip]).mean() < 2 < 8 < np.abs(true[lip]).max()
    assert np.isnan(moved[face.parts["tongue"]]).all()


def test_an_edge_whose_landmarks_fell_through_cuts_no_corner():
    face = load_face()
    there = face_landmarks(jawOpen=0.6)
    known = there.known.copy()
    known[list(EDGES["lower_lip"])[3:6]] = False
    moved = along_contours(face_mesh().vertices, face.contours, replace(there, known=known), face_landmarks())
    whole = along_contours(face_mesh().vertices, face.contours, there, face_landmarks())
    lip = face.contours["lower_lip"]
    gap = np.isnan(moved[lip, 0])
    assert 0.2 < gap.mean() < 0.8
    np.testing.assert_array_equal(moved[lip][~gap], whole[lip][~gap])
