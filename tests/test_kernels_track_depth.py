"""The depth kernels against their numpy twins."""

import numpy as np

from mien._kernels import track_depth, track_depth_twin
from mien.transforms import rotation_from_vector


def test_register_depth_agrees_with_its_twin():
    rng = np.random.default_rng(0)
    depth = rng.uniform(500, 700, (20, 30)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = 0
    R, t = rotation_from_vector(np.array([0.02, -0.05, 0.03])), np.array([12.0, -5.0, 3.0])
    arguments = (depth, np.array([40.0, 40, 15, 10]), R, t, np.array([65.0, 65, 24, 16]), 32, 48)
    fast, plain = (module.register_depth(*arguments) for module in (track_depth, track_depth_twin))
    np.testing.assert_allclose(fast, plain, rtol=1e-6)
