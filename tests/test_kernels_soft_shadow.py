"""Soft shadows against their numpy twin."""

import numpy as np
import pytest

from mien._kernels import soft_shadow, soft_shadow_twin
from samples import surface_samples


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def test_soft_shadow_agrees_with_its_twin(rng):
    samples = surface_samples(rng)
    scene = dict(
        **samples,
        lamp=np.array([0.0, 0.0, -1.0]),
        depth=rng.uniform(380, 420, (40, 40)).astype(np.float32),
        pose=np.eye(3, 4),
        lens=np.array([60.0, 19.5, 8.0]),
    )
    kernel = soft_shadow.soft_shadow(**scene, threads=2)
    np.testing.assert_allclose(kernel, soft_shadow_twin.soft_shadow(**scene), atol=1e-4)
    assert kernel[kernel > 0].std() > 0.1
