"""Rigid head motion and finding the head."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.tracking.detect import detect
from mien.tracking.preprocess_frame import PreprocessFrameConfig, preprocess_frame
from mien.tracking.rigid import RigidConfig, align, moved


def sighted(frame, marks=None, config=PreprocessFrameConfig(radius=0)):
    return preprocess_frame(frame, stage.CAMERA, None, marks, config)


def apart(a, b):
    """Mean distance of the front under two poses, mm."""
    points = stage.model().neutral.astype(float)
    return np.linalg.norm(a.apply(points) - b.apply(points), axis=1).mean()


def aligned(frame, start, **settings):
    m = stage.model()
    return align(m.neutral, m.faces, m.share, start, sighted(frame), RigidConfig(**settings))


def test_a_known_motion_is_found():
    rig, truth = stage.person(), stage.pose((0.05, -0.08, 0.04), (5, -4, 7))
    frame = stage.sensed(rig, np.zeros(len(rig.names)), truth)
    found = aligned(frame, stage.pose(), enough=0.02, iterations=30)
    assert apart(stage.pose(), truth) > 8
    assert apart(found.T_camera_face, truth) < 0.1


def test_icp_stops_when_the_mean_distance_is_small_enough_but_steps_once():
    rig = stage.person()
    frame = stage.sensed(rig, np.zeros(len(rig.names)), stage.pose())
    near = stage.pose(shift=(0, 0, 1.5))
    found = aligned(frame, near)
    assert (found.converged, found.iterations) == (True, 1)
    assert 1.0 < found.error < 1.6
    assert apart(found.T_camera_face, stage.pose()) < 0.15


def test_what_is_over_25_mm_away_is_pruned():
    rig = stage.person()
    frame = stage.sensed(rig, np.zeros(len(rig.names)), stage.pose())
    hand = frame.depth.copy()
    hand[100:150, 100:150] -= 60 * (hand[100:150, 100:150] > 0)
    found = aligned(replace(frame, depth=hand), stage.pose(shift=(2, 0, 2)), enough=0.05)
    assert found.covered < aligned(frame, stage.pose()).covered - 0.05
    assert apart(found.T_camera_face, stage.pose()) < 0.2


def test_an_empty_image_loses_the_head():
    rig = stage.person()
    frame = stage.sensed(rig, np.zeros(len(rig.names)), stage.pose())
    found = aligned(replace(frame, depth=np.zeros_like(frame.depth)), stage.pose())
    assert (found.converged, found.covered) == (False, 0.0)


def test_moved_turns_about_the_centre():
    T, centre = stage.pose((0.1, 0.2, 0.3)), np.array([1.0, 2, 600])
    after = moved(T, np.array([0.1, 0, 0.2, 0, 0, 0]), centre)
    here = T.inverse().apply(centre[None])
    np.testing.assert_allclose(after.apply(here)[0], centre, atol=1e-10)


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.2, 0.3, 0.1), (-0.2, -0.4, 0.0)])
def test_the_head_is_found_by_its_landmarks(turn):
    rig, truth = stage.person(), stage.pose(turn, (30, -20, 80))
    rest = np.zeros(len(rig.names))
    frame, marks = stage.sensed(rig, rest, truth), stage.told(rig, rest, truth)
    assert apart(detect(stage.model(), frame, marks, stage.CAMERA), truth) < 2.0
    blind = replace(frame, depth=None)
    assert apart(detect(stage.model(), blind, marks, stage.CAMERA), truth) < 2.0


def test_a_wrong_depth_scale_is_told_with_the_one_that_fits():
    rig, truth = stage.person(), stage.pose()
    rest = np.zeros(len(rig.names))
    frame, marks = stage.sensed(rig, rest, truth), stage.told(rig, rest, truth)
    large = replace(frame, depth=frame.depth * np.float32(10))
    with pytest.raises(BadInput, match=r"makes a face 1.\d+ m wide; multiply depth_scale .* by 9\.\d+|by 10"):
        detect(stage.model(), large, marks, stage.CAMERA)
