"""Scans laid out in an image: blending, and steps that fold nothing."""

import numpy as np

from mien.image_space.layout import Layout, blending, signed_areas
from mien.mesh import Mesh
from test_scans_correspond_fine_scale import FACES, regions, sheet


def test_blending_weights_add_up_and_fade_on_the_rim():
    masks = np.array([[[1.0, 0.0], [0.5, 0.5], [0.2, 0.0], [0.0, 0.0]]])
    weights = blending(masks)[0]
    np.testing.assert_allclose(weights[:2].sum(axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(weights[2, 0], (1 - np.cos(0.1 * np.pi)) / 0.5)
    np.testing.assert_array_equal(weights[3], 0)


def test_wild_steps_fold_nothing():
    layout = Layout(Mesh(sheet(), FACES), regions(), 1.0, alpha=0.0)
    steps = np.random.default_rng(0).normal(size=layout.home.shape) * 5
    moved = layout.moved(layout.home, steps)
    before, after = (signed_areas(x, layout.mesh.faces) for x in (layout.home, moved))
    assert (after * before > -1e-9).all()
    assert np.linalg.norm(moved - layout.home, axis=1).max() > 0.1
