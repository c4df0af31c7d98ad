"""Corrections of shapes from slip: found where the weights tell it, nothing where they do not."""

import numpy as np

import tracking_stage as stage
from mien.tracking.relearn.shape_corrections import (
    BLOCKS,
    CorrectionConfig,
    averaging,
    believed_corrections,
    corrections,
    foretold_share,
    nothing_missed,
)

FRAMES, SHAPES, VERTICES = 80, 4, 12


def summed(weights, slip):
    sums = nothing_missed(weights.shape[1], slip.shape[1])
    for t, (w, s) in enumerate(zip(weights, slip, strict=True)):
        sums.add(t * BLOCKS // len(weights), w, s.astype(np.float32))
    return sums


def case(noise):
    rng = np.random.default_rng(0)
    weights, shapes = rng.uniform(size=(FRAMES, SHAPES)), rng.normal(size=(SHAPES, VERTICES, 3))
    return weights, shapes, np.tensordot(weights, shapes, 1) + noise * rng.normal(size=(FRAMES, VERTICES, 3))


def test_the_share_foretold_is_that_of_frames_left_out_one_part_at_a_time():
    weights, _, slip = case(noise=1.0)
    block = np.arange(FRAMES) * BLOCKS // FRAMES
    left = np.zeros(VERTICES)
    for b in range(BLOCKS):
        W, S = weights[block != b], slip[block != b].reshape(-1, 3 * VERTICES)
        G = np.linalg.solve(W.T @ W + 2.0 * np.eye(SHAPES), W.T @ S).reshape(SHAPES, VERTICES, 3)
        left += ((slip[block == b] - np.tensordot(weights[block == b], G, 1)) ** 2).sum(axis=(0, 2))
    own = averaging(np.zeros((0, 3), int), VERTICES)
    found = foretold_share(summed(weights, slip), own, 2.0)
    np.testing.assert_allclose(found, 1 - left / (slip**2).sum(axis=(0, 2)), atol=2e-3)


def test_slip_that_comes_with_the_weights_is_the_shapes_and_noise_is_not():
    weights, shapes, slip = case(noise=0.0)
    sums = summed(weights, slip)
    found = corrections(sums.gram.sum(0), sums.product.sum(0), 1e-6).reshape(shapes.shape)
    np.testing.assert_allclose(found, shapes, atol=1e-3)
    own = averaging(np.zeros((0, 3), int), VERTICES)
    assert foretold_share(sums, own, 1e-6).min() > 0.99
    noise = np.random.default_rng(1).normal(size=slip.shape)
    assert foretold_share(summed(weights, noise), own, 1.0).max() < 0.1


def test_only_the_half_of_a_face_whose_slip_is_foretold_is_changed_and_never_the_rim():
    m, rng = stage.model(), np.random.default_rng(2)
    weights = rng.uniform(size=(FRAMES, m.shapes))
    left = m.neutral[:, 0] > 0
    slip = np.where(
        left[:, None], weights[:, :1, None] * np.array([0, 2.0, 0]), rng.normal(size=(FRAMES, len(left), 3))
    )
    found = believed_corrections(summed(weights, slip), m, CorrectionConfig(ridge=1e-4))
    inner = np.abs(m.neutral[:, 0]) > 25
    assert not found[:, ~left & inner].any()
    assert not found[:, m.rim].any()
    own = found[0, left & inner & (m.fade == 1)]
    np.testing.assert_allclose(own[:, 1], 2.0, atol=0.3)
