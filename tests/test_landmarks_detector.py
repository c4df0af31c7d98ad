import os

import numpy as np
import pytest

from face_model import needs_model
from mien import extras
from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.landmarks.detector import COUNT, GROUPS, FaceLandmarker, bundled_landmarks, detect_landmarks
from mien.landmarks.model_file import model_path
from mien.mesh import closest_point, submesh
from mien.pictures.render import Look, render
from mien.pictures.view import frontal_camera


@pytest.fixture(scope="module")
def picture():
    """The bundled face from the front and its landmarks' true pixels."""
    mesh = load_face().rig.neutral
    view = frontal_camera(mesh, 400)
    image = render(mesh, *view, Look(supersample=1, occlusion=0, softness=0.0))
    points = bundled_landmarks().attachment.points(mesh)
    return image, view.camera.project(view.T_camera_face.apply(points)), 400 / 280


def test_bundled_landmarks_are_symmetric():
    landmarks = bundled_landmarks()
    points = landmarks.attachment.points(load_face().rig.neutral)
    np.testing.assert_array_equal(landmarks.mirror[landmarks.mirror], np.arange(COUNT))
    np.testing.assert_allclose(points, points[landmarks.mirror] * [-1, 1, 1], atol=1e-3)


def test_left_is_the_subjects_left():
    landmarks = bundled_landmarks()
    points = landmarks.attachment.points(load_face().rig.neutral)
    for name in ("eye", "brow", "iris"):
        assert (points[landmarks.groups[f"{name}_left"], 0] > 0).all()
        np.testing.assert_array_equal(
            np.sort(landmarks.mirror[landmarks.groups[f"{name}_left"]]), np.sort(landmarks.groups[f"{name}_right"])
        )


def test_lids_lie_on_lids_and_irises_on_eyeballs():
    """Lid margins touch the eyeball; an iris is a disc of some 6 mm round the pupil."""
    face, landmarks = load_face(), bundled_landmarks()
    points = landmarks.attachment.points(face.rig.neutral)
    for side in ("left", "right"):
        ball, _ = submesh(face.rig.neutral, np.isin(face.rig.neutral.faces, face.parts[f"{side}_eye"]).all(axis=1))
        lids = landmarks.groups[f"eye_{side}"]
        inner = 362 if side == "left" else 133
        assert closest_point(ball, points[lids[lids != inner]]).distances.max() < 3.5
        iris = landmarks.groups[f"iris_{side}"]
        assert closest_point(ball, points[iris]).distances.max() < 1e-3
        radius = np.linalg.norm(points[iris[1:]] - points[iris[0]], axis=1)
        assert (radius > 4).all()
        assert (radius < 8).all()


def test_lips_part_where_the_jaw_opens():
    face, landmarks = load_face(), bundled_landmarks()
    weights = np.zeros(len(face.rig.names))
    weights[face.rig.index("jawOpen")] = 0.5
    shut, open_ = (landmarks.attachment.points(face.rig.mesh(w)) for w in (weights * 0, weights))
    assert abs(shut[13, 1] - shut[14, 1]) < 2
    assert open_[13, 1] - open_[14, 1] > 8
    assert (np.linalg.norm(open_[[0, 13]] - shut[[0, 13]], axis=1) < 2).all()


def test_groups_name_each_landmark_once():
    members = np.concatenate([GROUPS[name] for name in GROUPS])
    assert len(np.unique(members)) == len(members)
    assert not np.isin(bundled_landmarks().stable, [*GROUPS["contour"], *GROUPS["iris_left"]]).any()


@needs_model
def test_landmarks_are_found_where_they_are(picture):
    image, truth, pixels_per_mm = picture
    found = detect_landmarks(image)
    stable = bundled_landmarks().stable
    assert np.median(np.linalg.norm(found.points - truth, axis=1)[stable]) < 3 * pixels_per_mm
    assert len(found.scores) == 52
    assert found.scores["jawOpen"] < 0.2


@needs_model
def test_video_mode_keeps_its_own_clock(picture):
    with FaceLandmarker("video") as landmarker:
        first = landmarker.detect(picture[0], time=0.0)
        second = landmarker.detect(picture[0], time=0.0)
        third = landmarker.detect(picture[0])
    assert np.linalg.norm(third.points - first.points, axis=1).mean() < 1.5
    assert second is not None


@needs_model
def test_no_face_is_none():
    assert detect_landmarks(np.full((200, 200, 3), 128, np.uint8)) is None


@needs_model
def test_mediapipe_is_silent(picture, capfd):
    with FaceLandmarker() as landmarker:
        landmarker.detect(picture[0])
    assert capfd.readouterr().err == ""


def test_an_override_that_is_not_there_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(os.environ, "MIEN_FACE_LANDMARKER", str(tmp_path / "none.task"))
    with pytest.raises(BadInput, match="MIEN_FACE_LANDMARKER"):
        model_path()
    (tmp_path / "none.task").write_bytes(b"x")
    assert model_path() == tmp_path / "none.task"


def test_a_missing_model_says_what_to_run(monkeypatch, tmp_path):
    monkeypatch.delenv("MIEN_FACE_LANDMARKER", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(BadInput, match="mien fetch landmarks"):
        model_path()


@pytest.mark.parametrize(
    ("error", "advice"),
    [
        (ImportError("libGL.so.1: cannot open shared object file"), "apt install libgl1"),
        (OSError("libGLESv2.so.2: cannot open shared object file"), "apt install libgles2"),
        (ImportError("No module named 'mediapipe'"), r"mien\[landmarks\]"),
    ],
)
def test_what_is_missing_is_named_with_its_cure(monkeypatch, error, advice):
    def failing(name):
        raise error

    monkeypatch.setattr(extras, "import_module", failing)
    with pytest.raises(BadInput, match=advice):
        FaceLandmarker()
