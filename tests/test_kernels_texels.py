import numpy as np

from mien._kernels import texels, texels_twin


def test_displacements_agree_with_their_twin():
    rng = np.random.default_rng(2)
    base, skin = rng.normal(size=(30, 3)), rng.normal(size=(40, 3))
    skin[3] = np.nan
    frames = np.linalg.qr(rng.normal(size=(30, 3, 3)))[0]
    at, on = rng.integers(0, 30, (200, 3)).astype(np.int32), rng.integers(0, 40, (200, 3)).astype(np.int32)
    w, v = (rng.dirichlet(np.ones(3), 200).astype(np.float32) for _ in range(2))
    a, b = np.empty((200, 3)), np.empty((200, 3))
    texels.displacements(base, frames, at, w, skin, on, v, 2.0, a)
    texels_twin.displacements(base, frames, at, w, skin, on, v, 2.0, b)
    np.testing.assert_allclose(a, b, rtol=1e-6, atol=1e-6)
    assert 0 < np.isnan(a).all(axis=1).sum() < 200
