"""What blendshapes cannot say, as shapes of their own."""

import numpy as np

import tracking_stage as stage
from mien.tracking.correctives import CorrectiveBasis, CorrectiveConfig, with_correctives


def test_residuals_come_back_from_their_correctives():
    m, rng = stage.model(), np.random.default_rng(0)
    modes = rng.normal(size=(3, *m.neutral.shape)) * m.fade[:, None]
    rows = rng.normal(size=(50, 3))
    space = CorrectiveBasis(m, CorrectiveConfig(shapes=8, block=12, tolerance=1e-3))
    for row in rows:
        space.add(np.tensordot(row, modes, 1).astype(np.float32))
    shapes, weights = space.finish()
    assert len(shapes) == 3
    assert np.abs(weights).max() <= 1 + 1e-6
    expected = np.tensordot(rows, modes, 1) * m.fade[:, None]
    np.testing.assert_allclose(np.tensordot(weights, shapes, 1), expected, atol=2e-3)
    rig = with_correctives(stage.person(), m, shapes)
    assert rig.names[-3:] == ("corrective_01", "corrective_02", "corrective_03")


def test_no_residuals_no_correctives():
    shapes, weights = CorrectiveBasis(stage.model(), CorrectiveConfig(shapes=0)).finish()
    assert (len(shapes), weights.size) == (0, 0)
