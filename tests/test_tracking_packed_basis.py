"""A packed basis says what the plain one says."""

import numpy as np

import tracking_stage as stage
from mien.tracking.packed_basis import LEAST, pack


def test_every_vertex_stands_in_one_block_and_blends_as_plainly():
    model = stage.model()
    packed = pack(model.neutral.astype(float), model.basis.astype(float))
    assert sorted(packed.order[packed.order >= 0].tolist()) == list(range(len(model.neutral)))
    weights = np.random.default_rng(0).uniform(0, 1, model.shapes)
    plain = model.neutral + model.basis @ weights
    assert np.abs(packed.blend(model.neutral, weights) - plain).max() < LEAST * model.shapes
    assert np.abs(packed.blend(model.neutral, weights) - plain).mean() < LEAST


def test_a_shape_that_moves_one_corner_stands_in_its_blocks_alone():
    points = np.random.default_rng(1).uniform(0, 100, (300, 3))
    basis = np.zeros((300, 3, 2))
    basis[:, 0, 0] = 1.0
    corner = np.flatnonzero(points[:, 0] < 5)
    basis[corner, 1, 1] = 2.0
    packed = pack(points, basis)
    with_second = (packed.columns == 1).any(axis=1)
    assert 0 < with_second.sum() < len(with_second)
    blended = packed.blend(points.astype(np.float32), np.array([0.0, 1.0])) - points.astype(np.float32)
    np.testing.assert_allclose(blended[corner, 1], 2.0, atol=1e-4)
    assert not np.delete(blended, corner, axis=0).any()
