"""Fusing depth against its numpy twin."""

import numpy as np

import tracking_stage as stage
from kernel_scene import INTRINSICS
from mien._kernels import tsdf, tsdf_twin


def test_integration_agrees():
    rng = np.random.default_rng(5)
    depth = rng.uniform(570, 630, (240, 320)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.1] = 0
    T, volumes = stage.pose((0.1, 0.2, 0)), []
    for module in (tsdf, tsdf_twin):
        distance, weight = np.ones((20, 22, 24), np.float32), np.zeros((20, 22, 24), np.float32)
        for _ in range(2):
            corner = np.array([-20.0, -22, -24])
            module.integrate(distance, weight, corner, 2.0, T.rotation, T.translation, depth, INTRINSICS, 6.0, 9.0)
        volumes.append((distance, weight))
    for a, b in zip(*volumes, strict=True):
        assert (a != b).mean() < 1e-3
        np.testing.assert_allclose(np.median(np.abs(a - b)), 0, atol=1e-6)
    assert volumes[0][1].max() == 2
