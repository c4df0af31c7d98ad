import numpy as np

from mien._kernels import photometric, photometric_twin


def test_normals_agree_with_their_twin():
    rng = np.random.default_rng(0)
    light, truth = rng.normal(size=(200, 7, 3)), rng.normal(size=(200, 3))
    values = np.einsum("pki,pi->pk", light, truth) + 0.01 * rng.normal(size=(200, 7))
    values[:, 2] += 2.0
    usable, scales = rng.random((200, 7)) < 0.9, rng.uniform(0.05, 0.1, 200)
    usable[0] = False
    made = []
    for module in (photometric, photometric_twin):
        normals, weights = np.zeros((200, 3)), np.zeros((200, 7))
        module.robust_normals(values, light, usable, scales, 8, normals, weights)
        made.append((normals, weights))
    for one, other in zip(*made, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-7)
    assert np.median(np.abs(made[0][0] - truth)) < 0.02
