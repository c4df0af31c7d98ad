"""Head motion taken out of a take."""

import numpy as np
import pytest

from marker_stage import motion
from mien.clip import Markers
from mien.errors import BadInput
from mien.takes.stabilise import calm_frames, mean_cloud, stabilise


def test_stabilise_takes_out_head_motion_and_trusts_still_markers():
    rng = np.random.default_rng(1)
    rest, T = rng.normal(size=(12, 3)) * 50, motion(200, 2)
    face = np.repeat(rest[None], 200, axis=0)
    face[:, 8:, 1] += 8 * np.abs(np.sin(np.linspace(0, 20, 200)))[:, None]
    X = T.apply(face)
    X[rng.random(X.shape[:2]) < 0.05] = np.nan
    done = stabilise(Markers(X, tuple("abcdefghijkl"), 60.0))
    still = done.markers.positions[:, :8]
    assert np.nanmax(np.nanstd(still, axis=0)) < 0.15
    assert done.weights[:8].min() > 3 * done.weights[8:].max()


def test_stabilise_needs_three_markers_somewhere():
    X = np.full((5, 8, 3), np.nan)
    X[:, :2] = 0.5
    with pytest.raises(BadInput, match="fewer than 3 markers"):
        stabilise(Markers(X, tuple("abcdefgh"), 30.0))


def test_the_calm_frame_is_the_one_dwelt_at_whatever_its_place():
    rng = np.random.default_rng(3)
    X = rng.normal(size=(1, 10, 3)) * 40 + 3 * rng.normal(size=(300, 1, 3)) * rng.normal(size=(1, 10, 3))
    X[200:240] = X[200] + 0.01 * rng.normal(size=(40, 10, 3))
    first = calm_frames(X)[0]
    assert 200 <= first < 240
    np.testing.assert_allclose(mean_cloud(X, first), X[200], atol=0.05)
