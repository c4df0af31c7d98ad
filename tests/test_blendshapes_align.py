"""Expressions in the neutral's frame."""

import numpy as np
import pytest

from blendshape_faces import face_landmarks, face_map, face_mesh
from mien.blendshapes.align import HeadAlignConfig, align, forehead, laid_on, moved_map, stabilised
from mien.blendshapes.correspond.landmarks import MapLandmarks
from mien.errors import BadInput
from mien.mesh import ClosestPoint, Mesh
from mien.register.correspond import Surface
from mien.transforms import Transform, rotation_from_vector

OFF = Transform(rotation_from_vector(np.array([0.06, -0.08, 0.03])), np.array([4.0, -3.0, 5.0]))


def turn_off(T: Transform) -> float:
    """How far a point on the face is off its place, mm."""
    here = np.array([[0, 0, 100.0], [40, -60, 80.0]])
    return float(np.linalg.norm((T @ OFF).apply(here) - here, axis=1).max())


@pytest.fixture(scope="module")
def jaw():
    return moved_map(face_map("jaw", jawOpen=0.7), OFF), face_landmarks(jawOpen=0.7).moved(OFF)


def test_the_forehead_brings_an_open_mouth_into_the_neutrals_frame(jaw):
    found = align(*jaw, face_map(), face_landmarks())
    assert turn_off(found.T_neutral_capture) < 0.5
    assert found.map.known.sum() > 0.9 * face_map().known.sum()


def test_landmarks_hold_what_slides_on_a_ball():
    grid = np.stack(np.meshgrid(np.linspace(-50, 50, 41), np.linspace(-50, 50, 41)), -1).reshape(-1, 2)
    ball = np.column_stack([grid, np.sqrt(90.0**2 - (grid**2).sum(1))])
    index = np.arange(41 * 41).reshape(41, 41)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]))
    surface = Surface(Mesh(ball, np.concatenate([np.stack([a, c, b], 1), np.stack([c, d, b], 1)])))
    turned = Transform(rotation_from_vector(np.array([0.03, 0.02, 0.0])), np.zeros(3))
    middle = ball[np.abs(grid).max(1) < 35]
    marks = middle[::150]
    pairs = turned.apply(marks), marks
    loose, _ = laid_on(turned.apply(middle), surface, pairs, Transform.identity(), HeadAlignConfig(landmark_share=0.0))
    held, _ = laid_on(turned.apply(middle), surface, pairs, Transform.identity())
    off = [np.linalg.norm((T @ turned).apply(marks) - marks, axis=1).max() for T in (loose, held)]
    assert off[1] < 0.1 < 1 < off[0]


def test_skin_that_moved_as_one_holds_the_head_still():
    still, moving = face_mesh().vertices, face_mesh(jawOpen=0.8).vertices
    T = stabilised(OFF.apply(moving), still, np.ones(len(still)))
    assert turn_off(T) < 0.2


def test_the_forehead_is_above_the_brows():
    mask = forehead(face_map(), face_landmarks(), bridge=False)
    heights = face_map().positions[mask][:, 1]
    assert heights.min() > 5
    assert mask.sum() > 1500


def test_a_moved_map_is_the_moved_surface():
    points = moved_map(face_map(), OFF).positions.reshape(-1, 3)
    points = points[np.isfinite(points[:, 0])][::50].astype(float)
    assert ClosestPoint(face_mesh()).query(OFF.inverse().apply(points)).distances.max() < 0.5


def test_scans_without_eyes_or_forehead_are_refused(jaw):
    blind = MapLandmarks(jaw[1].points, np.zeros(478, bool))
    with pytest.raises(BadInput, match="cannot be laid on the neutral"):
        align(jaw[0], blind, face_map(), face_landmarks())
    cut = face_map().positions.copy()
    cut[cut[..., 1] > -20] = np.nan
    low = type(face_map())(face_map().layout, cut, face_map().colors, face_map().confidence, "cut")
    with pytest.raises(BadInput, match="cut off"):
        align(low, face_landmarks(), face_map(), face_landmarks())
