"""Where landmarks lie on a rig."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.landmarks.on_rig import (
    FEATURES,
    LandmarkMap,
    attach_landmarks,
    feature_points,
    lift,
    shade,
    skin_faces,
    view_of_face,
)


def test_landmarks_come_back_from_their_file_and_only_for_their_rig(tmp_path):
    rig, landmarks = stage.person(5), stage.landmarks()
    landmarks.save(tmp_path / "rig.landmarks.json")
    back = LandmarkMap.load(tmp_path / "rig.landmarks.json", rig.neutral)
    np.testing.assert_array_equal(back.known, landmarks.known)
    mesh, known = rig.neutral, landmarks.known
    expected = landmarks.attachment.points(mesh)[known]
    np.testing.assert_allclose(back.attachment.points(mesh)[known], expected, atol=0.01)
    few = replace(mesh, faces=mesh.faces[:50], uv=None, uv_faces=None)
    with pytest.raises(BadInput, match="written for another rig"):
        LandmarkMap.load(tmp_path / "rig.landmarks.json", few)
    (tmp_path / "bad.json").write_text("[]")
    with pytest.raises(BadInput, match="not a landmark file"):
        LandmarkMap.load(tmp_path / "bad.json", mesh)


def test_lid_landmarks_lie_on_skin_though_eyeballs_are_nearer():
    mesh = load_face().rig.neutral
    points = stage.landmarks().attachment.points(mesh) + np.array([0, 0, 0.2])
    placed = attach_landmarks(mesh, points, np.ones(478, bool))
    assert skin_faces(mesh)[placed.attachment.faces[:468]].all()


def test_what_is_seen_in_a_picture_comes_back_to_the_surface():
    """Landmarks that look at the camera, seen in a turned view and lifted, are where they are."""
    mesh = load_face().rig.neutral
    camera, T = view_of_face(mesh, tilt=0.1, turn=-0.2)
    picture, hits = shade(mesh, camera, T)
    points = stage.landmarks().attachment.points(mesh)
    lifted = lift(camera.project(T.apply(points)), hits, mesh)
    off = np.linalg.norm(lifted - points, axis=1)[list(FEATURES)]
    assert np.nanmedian(off) < 1.5
    assert (picture[hits.faces < 0] == 90).all()
    assert np.isnan(lift(np.array([[-5.0, 3.0], [0.0, 0.0]]), hits, mesh)).all()


def test_an_unknown_landmark_is_no_number():
    mesh = load_face().rig.neutral
    some = replace(stage.landmarks(), known=np.arange(478) != 7)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(feature_points(some, mesh)).all(axis=1)), [7])
