"""A face, whole or in part, found by its depth alone."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.tracking.hidden.find_in_depth import find_in_depth
from mien.tracking.hidden.lower_face import lower_face_model
from mien.tracking.rigid import RigidConfig


@pytest.fixture(scope="module")
def model():
    return lower_face_model(stage.person(), stage.landmarks())


@pytest.mark.parametrize(
    "pose",
    [stage.pose(distance=550.0), stage.pose((0.15, 0.35, 0.1), (60.0, -40.0, 0.0)), stage.pose((-0.2, -0.3, 0.0))],
)
def test_a_head_is_found_wherever_it_is(model, pose):
    frame = stage.sensed(stage.person(), np.zeros(52), pose, noise=0.5)
    found = find_in_depth(model, frame, stage.CAMERA, RigidConfig())
    assert found is not None
    off = np.linalg.norm(found.apply(model.neutral) - pose.apply(model.neutral), axis=1)
    assert off.mean() < 3.0


def test_where_there_is_none_nothing_is_found(model):
    frame = stage.sensed(stage.person(), np.zeros(52), stage.pose())
    assert frame.depth is not None
    wall = replace(frame, depth=np.full_like(frame.depth, 700.0))
    assert find_in_depth(model, wall, stage.CAMERA, RigidConfig()) is None
    assert find_in_depth(model, replace(frame, depth=np.zeros_like(frame.depth)), stage.CAMERA, RigidConfig()) is None
    assert find_in_depth(model, replace(frame, depth=None), stage.CAMERA, RigidConfig()) is None
