"""Scans laid out in an image: blending, and steps that fold nothing."""

import numpy as np

from mien.image_space.layout import Layout, blending, signed_areas
from mien.mesh import Mesh, submesh
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


def test_where_one_layer_lies_over_another_nothing_moves_onto_the_wrong_one():
    near = np.abs(sheet()[FACES].mean(axis=1)[:, :2]).max(axis=1) < 15
    inner = submesh(Mesh(0.8 * sheet(), FACES), near)[0]
    both = Mesh(np.concatenate([sheet(), inner.vertices]), np.concatenate([FACES, inner.faces + len(sheet())]))
    everywhere = {"all": np.ones(len(both.vertices))}
    layout = Layout(both, everywhere, 1.0, alpha=0.0)
    moved = layout.moved(layout.home, np.full(layout.home.shape, 1.2))
    slid = np.linalg.norm(layout.on_surface(moved).points(layout.mesh) - layout.mesh.vertices, axis=1)
    went = (moved != layout.home).any(axis=1)
    assert slid[went].max() < 4.0
    assert not went[layout.held].any()
    assert 0.3 < went.mean() < 0.9


def test_layers_that_lie_over_nothing_are_not_held():
    assert not Layout(Mesh(sheet(), FACES), regions(), 1.0, alpha=0.0).held.any()
