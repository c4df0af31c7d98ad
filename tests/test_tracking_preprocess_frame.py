"""One frame, cropped and cleaned."""

from dataclasses import replace

import numpy as np

import tracking_stage as stage
from mien.depth import RGBDFrame
from mien.landmarks.detector import Landmarks2D
from mien.tracking.preprocess_frame import PreprocessFrameConfig, preprocess_frame, scores_of, usable
from mien.tracking.terms.photometric import PhotometricConfig

SHAPE = (stage.CAMERA.height, stage.CAMERA.width)


def wall(noise: float = 1.0):
    """A wall with a step of 50 mm, seen by a noisy sensor."""
    depth = np.full(SHAPE, 600.0)
    depth[:, 160:] = 650.0
    depth += np.random.default_rng(0).normal(0, noise, SHAPE)
    return RGBDFrame(np.full((*SHAPE, 3), 120, np.uint8), depth.astype(np.float32), 0.0)


def test_noise_falls_and_steps_stay():
    seen = preprocess_frame(wall(), stage.CAMERA, None, None)
    assert seen.depth[:, :150].std() < 0.6
    np.testing.assert_allclose(np.diff(seen.depth[:, 159:161]).mean(), 50.0, atol=1.0)
    plain = preprocess_frame(wall(), stage.CAMERA, None, None, PreprocessFrameConfig(radius=0))
    np.testing.assert_array_equal(plain.depth, wall().depth)


def test_a_window_has_the_camera_of_its_pixels():
    around = np.array([[100.0, 80.0], [140.0, 120.0]])
    seen = preprocess_frame(wall(), stage.CAMERA, around, None, PreprocessFrameConfig(window=100, radius=0))
    assert seen.depth.shape[0] < SHAPE[0]
    point = np.array([[10.0, -20.0, 600.0]])
    moved = stage.CAMERA.project(point) - seen.camera.project(point)
    column, row = np.round(moved[0]).astype(int)
    h, w = seen.depth.shape
    np.testing.assert_array_equal(seen.depth, wall().depth[row : row + h, column : column + w])


def test_what_is_no_number_is_no_depth():
    frame = wall()
    frame.depth[:5] = np.nan
    frame.depth[5:9] = np.inf
    assert not preprocess_frame(frame, stage.CAMERA, None, None, PreprocessFrameConfig(radius=0)).depth[:9].any()


def test_landmarks_become_lines_of_sight_and_colour_contrast():
    marks = stage.told(stage.person(), np.zeros(52), stage.pose())
    seen = preprocess_frame(wall(), stage.CAMERA, None, marks, photometric=PhotometricConfig())
    np.testing.assert_allclose(stage.CAMERA.project(np.column_stack([seen.rays, np.ones(478)])), marks.points)
    assert len(seen.contrast) == len(set(PhotometricConfig().smooth))
    assert preprocess_frame(wall(), stage.CAMERA, None, marks).contrast is None
    without = seen.without_landmarks()
    assert (without.rays, without.landmark_scores) == (None, None)


def test_half_of_the_landmarks_must_be_numbers():
    marks = stage.told(stage.person(), np.zeros(52), stage.pose())
    points = marks.points.copy()
    points[:200] = np.nan
    assert usable(replace(marks, points=points)) is not None
    points[:300] = np.inf
    assert usable(replace(marks, points=points)) is None
    assert usable(None) is None


def test_scores_are_by_name_and_what_is_no_score_is_nan():
    marks = Landmarks2D(np.zeros((478, 2)), np.zeros(478), {"jawOpen": 0.4, "cheekPuff": 7.0})
    np.testing.assert_array_equal(scores_of(marks, ("cheekPuff", "jawOpen", "other")), [np.nan, 0.4, np.nan])
    assert np.isnan(scores_of(None, ("jawOpen",))).all()
