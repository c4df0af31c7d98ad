"""A face beside its own depth image."""

from functools import cache

import numpy as np

import tracking_stage as stage
from mien._kernels import icp, track

INTRINSICS = np.array([262.5, 262.5, 159.5, 119.5])


@cache
def face_and_depth():
    """Model, pose, points, normals and depth, so that there is something to correspond."""
    rig, model = stage.person(), stage.model()
    frame = stage.sensed(rig, stage.named(rig, jawOpen=0.3), stage.pose((0.05, 0.1, 0), (2, 1, 4)), noise=0.5)
    T = stage.pose()
    points = T.apply(model.neutral.astype(float)).astype(np.float32)
    normals = track.vertex_normals(points, model.faces)
    return model, T, points, normals, frame.depth


def matched(scene):
    _, _, points, normals, depth = scene
    return icp.correspond(points, normals, depth, INTRINSICS, np.float32(25), np.float32(0.3), 2)
