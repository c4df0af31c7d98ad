"""Coefficients on the final mesh."""

import numpy as np
import pytest

import tracking_stage as stage
from mien.tracking.reproject_weights import WeightReprojection, box_solve


def test_known_coefficients_come_back_and_near_decides_where_the_mesh_does_not():
    model = stage.model()
    truth = stage.named(model.rig, jawOpen=0.6, mouthSmileLeft=0.5)
    solver = WeightReprojection(model, ridge=0.0, near_weight=1e-3)
    found = solver.weights(model.blend(truth), np.zeros(model.shapes))
    np.testing.assert_allclose(found[truth > 0], truth[truth > 0], atol=0.03)
    assert np.abs(found - truth).mean() < 0.02
    near = np.full(model.shapes, 0.3)
    silent = model.size < 1e-6
    held = WeightReprojection(model, ridge=0.0).weights(model.blend(truth), near)
    np.testing.assert_allclose(held[silent], 0.3, atol=1e-3)


def test_a_box_by_hand_and_a_system_that_is_not_finite():
    gram, linear = np.diag([2.0, 4.0, 1.0]), np.array([1.0, 8.0, -3.0])
    values, breach = box_solve(gram, linear, np.zeros(3), np.ones(3), np.zeros(3))
    np.testing.assert_allclose(values, [0.5, 1.0, 0.0], atol=1e-9)
    assert breach < 1e-6
    warm = np.array([0.2, 5.0, -1.0])
    values, breach = box_solve(gram * np.nan, linear, np.zeros(3), np.ones(3), warm)
    np.testing.assert_array_equal(values, [0.2, 1.0, 0.0])
    assert breach == pytest.approx(np.inf)
