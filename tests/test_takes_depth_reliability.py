"""Whether depth was measured."""

import numpy as np

from marker_stage import motion
from mien.takes.depth_reliability import depth_metric


def test_depth_of_one_camera_is_told_from_depth_of_many():
    rng = np.random.default_rng(4)
    rest = rng.uniform(-50, 50, size=(16, 3)) * [1, 1, 0.3]
    moved = rest + rng.normal(size=(300, 16, 3)) * [2, 3, 1.5]
    real = motion(300, 5).apply(moved)
    flat = moved.copy()
    flat[..., 2] = 20 - 0.004 * (flat[..., 0] ** 2 + flat[..., 1] ** 2)
    assert depth_metric(real).known
    found = depth_metric(flat)
    assert not found.known
    assert np.linalg.eigvalsh(found.metric)[0] < 0.05
