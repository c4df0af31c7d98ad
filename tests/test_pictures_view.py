"""Cameras that see all of a face."""

import numpy as np
import pytest

from mien.mesh import Mesh
from mien.pictures import frontal_camera
from round_things import sphere


@pytest.mark.parametrize(("yaw", "pitch"), [(0.0, 0.0), (0.7, 0.0), (-0.5, 0.4)])
def test_frontal_camera_frames_all_of_it(yaw, pitch):
    rng = np.random.default_rng(3)
    mesh = Mesh(rng.normal(size=(200, 3)) * (60, 90, 50) + (5, 20, 40), np.array([[0, 1, 2]]))
    camera, T_camera_face = frontal_camera(mesh, (120, 200), yaw, pitch, margin=0.1)
    local = T_camera_face.apply(mesh.vertices)
    pixels = camera.project(local)
    assert (local[:, 2] > 0).all()
    low, high = pixels.min(0), pixels.max(0)
    assert (low > (10, 18)).all()
    assert (high < (110, 182)).all()
    # as near as that allows, and in the middle
    assert min((low - (11.5, 19.5)).min(), ((107.5, 179.5) - high).min()) < 4
    np.testing.assert_allclose((low + high) / 2, (59.5, 99.5), atol=2.5)
    # yaw > 0 looks from the subject's left, pitch > 0 from above
    eye = T_camera_face.inverse().translation - mesh.vertices.mean(0)
    np.testing.assert_allclose(np.arctan2(eye[0], eye[2]), yaw, atol=0.08)
    np.testing.assert_allclose(np.arcsin(eye[1] / np.linalg.norm(eye)), pitch, atol=0.08)


def test_frontal_camera_can_frame_a_part():
    mesh = sphere(50)
    part = mesh.vertices[mesh.vertices[:, 1] > 20]
    camera, T = frontal_camera(mesh, 100, frame=part)
    pixels = camera.project(T.apply(part))
    assert (pixels > 0).all()
    assert (pixels < 99).all()
    assert camera.project(T.apply(mesh.vertices)).max() > 100
