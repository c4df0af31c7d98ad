"""Frames of a capture and where the head is in each."""

from dataclasses import replace

import numpy as np
import pytest

from blendshape_stage import TrueLandmarks, capture
from mien.blendshapes.scan.frames import (
    FramesConfig,
    PlacedFrame,
    frame_mesh,
    frames_with_face,
    place_by_landmarks,
    place_by_surface,
    reference_frame,
)
from mien.errors import BadInput
from mien.mesh import ClosestPoint, face_normals


@pytest.fixture(scope="module")
def seen():
    take, landmarker, _ = capture("neutral")
    return frames_with_face(take, landmarker)


def test_the_straightest_frame_is_the_reference(seen):
    truth = capture("neutral")[2]
    best, T_face_camera = reference_frame(seen, "neutral")
    assert best in np.argsort(truth.T_lab_face.rotation[:, 2, 2])[:2]
    found = (T_face_camera @ truth.T_lab_face[best]).rotation
    assert np.degrees(np.arccos((np.trace(found) - 1) / 2)) < 6


def test_landmarks_and_then_depth_find_the_head(seen):
    take, _, truth = capture("neutral")
    reference, T_face_camera = reference_frame(seen, "neutral")
    far = int(np.argmax(np.abs(truth.T_lab_face.rotation[:, 0, 2])))
    start, moved = place_by_landmarks(seen[far], seen[reference], T_face_camera)
    true = T_face_camera @ truth.T_lab_face[reference] @ truth.T_lab_face[far].inverse()
    middle = np.nanmedian(seen[far].landmarks, axis=0)[None]
    tree = ClosestPoint(frame_mesh(PlacedFrame(seen[reference], T_face_camera), take.camera)[0])
    placed = place_by_surface(seen[far], start, tree, take.camera, FramesConfig())
    assert placed is not None
    assert moved < 4
    assert np.linalg.norm(placed.T_face_camera.apply(middle) - true.apply(middle)) < 1.5


def test_a_frame_that_does_not_fit_is_refused(seen):
    take = capture("neutral")[0]
    reference, T_face_camera = reference_frame(seen, "neutral")
    tree = ClosestPoint(frame_mesh(PlacedFrame(seen[reference], T_face_camera), take.camera)[0])
    bent = replace(seen[3], depth=seen[3].depth + 25 * np.sin(np.arange(640) / 9).astype(np.float32))
    assert place_by_surface(bent, T_face_camera, tree, take.camera, FramesConfig()) is None


def test_a_frames_surface_faces_the_sensor(seen):
    take = capture("neutral")[0]
    mesh, cosines = frame_mesh(PlacedFrame(seen[0], reference_frame(seen, "n")[1]), take.camera)
    assert face_normals(mesh.vertices, mesh.faces)[:, 2].mean() > 0.3
    assert cosines.min() >= 0
    assert cosines.max() <= 1 + 1e-9


def test_takes_without_depth_or_face_are_refused():
    take, _, _ = capture("neutral")
    with pytest.raises(BadInput, match="has no depth"):
        frames_with_face(replace(take, has_depth=False))
    blind = TrueLandmarks({})
    blind.detect = lambda image, time=None: None
    with pytest.raises(BadInput, match="no frame shows a face"):
        frames_with_face(take, blind)


def test_depth_in_another_unit_is_told(seen):
    small = [replace(one, landmarks=one.landmarks / 10) for one in seen]
    with pytest.raises(BadInput, match="--depth-scale"):
        reference_frame(small, "take")
