from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.camera import Camera
from mien.errors import BadInput
from mien.light.calibrate import Board, BoardConfig, BoardView, board_view, calibrate, corner_in_projector
from mien.light.disk.light_take import pictures_of, read_grey
from mien.light.light_rig import RigView
from mien.light.patterns import gray_set
from mien.transforms import Transform, rotation_from_vector

pytest.importorskip("cv2")
PROCAM = Path(__file__).resolve().parents[2] / "shared" / "data" / "procam"
BOARD = Board(7, 5, 30.0)
CAMERA = RigView(
    "camera", Camera(1500, 1505, 640, 500, 1280, 1024), Transform.identity(), (-0.1, 0.05, 0.001, 0.0, 0.0)
)
POSE = Transform(rotation_from_vector(np.array([0.05, -0.2, 0.02])), np.array([150.0, 20.0, 10.0]))
PROJECTOR = RigView("projector", Camera(1200, 1198, 500, 400, 1024, 768), POSE)


def poses(count, noise=0.05, seed=0):
    rng = np.random.default_rng(seed)
    out = []
    for k in range(count):
        R = rotation_from_vector(0.4 * rng.normal(size=3))
        T = Transform(R, np.array([0, 0, 700.0]) + 40 * rng.normal(size=3) - R @ BOARD.points.mean(axis=0))
        seen = [v.distorted(v.camera.project(v.T_view_rig.apply(T.apply(BOARD.points)))) for v in (CAMERA, PROJECTOR)]
        out.append(BoardView(f"pose_{k}", *(px + noise * rng.normal(size=px.shape) for px in seen)))
    return out


def test_lenses_and_the_projectors_place_are_found():
    found = calibrate(poses(8), BOARD, (1280, 1024), (1024, 768))
    camera, projector = found.rig.cameras[0], found.rig.projector
    assert found.rms_px["stereo"] < 0.1
    assert camera.camera.fx == pytest.approx(1500, rel=0.01)
    assert projector.camera.cx == pytest.approx(500, abs=15)
    np.testing.assert_allclose(projector.T_view_rig.translation, POSE.translation, atol=5)
    assert camera.distortion[0] == pytest.approx(-0.1, abs=0.02)


def test_a_bad_pose_is_named_and_left_out():
    views = poses(6)
    views[2] = replace(
        views[2], projector_px=views[2].projector_px + 15 * np.random.default_rng(1).normal(size=(35, 2))
    )
    found = calibrate(views, BOARD, (1280, 1024), (1024, 768))
    assert found.left_out == ("pose_2",)
    assert found.rms_px["stereo"] < 0.1
    with pytest.raises(BadInput, match="2 poses can be used"):
        calibrate(views[:2], BOARD, (1280, 1024), (1024, 768))


def test_a_corner_is_read_through_the_patterns_round_it():
    y, x = np.mgrid[:200, :240].astype(float)
    scale = 1 + 0.001 * x
    pixels = np.round(np.stack([(0.5 * x + 0.1 * y + 30) / scale, (0.6 * y + 40) / scale], -1))
    truth = np.array([(0.5 * 120.5 + 0.1 * 90.25 + 30) / 1.1205, (0.6 * 90.25 + 40) / 1.1205])
    np.testing.assert_allclose(corner_in_projector(np.array([120.5, 90.25]), pixels, BoardConfig()), truth, atol=0.1)
    assert np.isnan(corner_in_projector(np.array([5.0, 5.0]), np.full_like(pixels, np.nan), BoardConfig())).all()


@pytest.mark.data
@pytest.mark.skipif(not PROCAM.is_dir(), reason="no recording of a board under Gray codes beside the checkout")
def test_a_real_camera_and_projector_calibrate_below_the_recordings_own_error():
    patterns, board = gray_set(1024, 768), Board(9, 7, 75.0)
    views = []
    for k in (0, 2, 4):
        images = np.stack([read_grey(path) for path in pictures_of(PROCAM / f"capture_{k}")])
        views.append(board_view(f"capture_{k}", images, patterns, board))
    found = calibrate(views, board, (1280, 1024), (1024, 768))
    assert found.left_out == ()
    assert found.rms_px["stereo"] < 0.5
    with pytest.raises(BadInput, match="no checkerboard of 9 x 7"):
        board_view("empty", np.full_like(images, 0.5), patterns, board)
