"""Paint that is one person's."""

import numpy as np
import scipy.sparse as sp

from mien.faces.bundled import load_face
from mien.stage.people.albedo import albedo


def test_skin_is_a_persons_and_eyes_keep_their_paint():
    mesh = load_face().rig.neutral
    n = len(mesh.vertices)
    is_skin = np.zeros(n, bool)
    is_skin[load_face().parts["skin"]] = True
    same = sp.csr_matrix(sp.identity(n))
    one, again, other = (
        albedo(mesh, same, same, mesh.vertices, is_skin, np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, again)
    assert np.abs(one - other)[is_skin].mean() > 0.01
    np.testing.assert_allclose(one[~is_skin], mesh.colors[~is_skin])
    assert 0 <= one.min() <= one.max() <= 1


def test_brows_are_darker_than_the_skin_around():
    mesh = load_face().rig.neutral
    same, skin = sp.csr_matrix(sp.identity(len(mesh.vertices))), np.ones(len(mesh.vertices), bool)
    bright = albedo(mesh, same, same, mesh.vertices, skin, np.random.default_rng(4)) @ [0.3, 0.6, 0.1]
    paint = mesh.colors @ [0.3, 0.6, 0.1]
    front = (mesh.vertices[:, 1] > 8) & (mesh.vertices[:, 2] > 35)
    brow = front & (paint < np.median(paint) - 0.1)
    assert brow.sum() > 10
    assert np.median(bright[brow]) < 0.8 * np.median(bright[front & ~brow])
