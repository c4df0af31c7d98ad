"""Calm depth frames merged into one scan."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.mesh import ClosestPoint, face_normals
from mien.tracking.person.aggregate import AggregateConfig, aggregate


def test_merged_frames_are_closer_to_the_truth_than_any_single_one():
    take, _, poses = stage.calm()
    merged = aggregate(list(take), stage.CAMERA, poses[0])
    truth = ClosestPoint(stage.person(5).neutral)
    assert all(pose is not None for pose in merged.T_camera_face)
    assert truth.query(merged.scan.vertices).distances.mean() < 0.35
    assert (face_normals(merged.scan.vertices, merged.scan.faces)[:, 2] > 0).mean() > 0.9


def test_frames_that_do_not_hold_still_are_refused():
    take, _, poses = stage.calm()
    frames = [replace(f, depth=f.depth + np.float32(40 * i) * (f.depth > 0)) for i, f in enumerate(take)]
    with pytest.raises(BadInput, match="hold still enough"):
        aggregate(frames, stage.CAMERA, poses[0], AggregateConfig(enough=0.5))


def test_no_depth_where_the_face_is():
    take, _, poses = stage.calm()
    empty = [replace(f, depth=np.zeros_like(f.depth)) for f in take]
    with pytest.raises(BadInput, match="no depth where the landmarks see the face"):
        aggregate(empty, stage.CAMERA, poses[0])
