"""Wild samples, ghosts and swapped labels."""

import numpy as np
import pytest

from marker_stage import motion
from mien.clip import Markers
from mien.takes.outliers import OutlierConfig, nearest_markers, remove_outliers, sudden_runs

FRAMES = 240


@pytest.fixture(scope="module")
def clean():
    """Thirty markers on a bent sheet that a few smooth motions move, under head motion."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.linspace(-60, 60, 6), np.linspace(-70, 70, 5))
    rest = np.stack([x.ravel(), y.ravel(), -(x.ravel() ** 2) / 120], 1)
    time = np.arange(FRAMES)[:, None] / 60
    sources = np.maximum(np.sin(time * [2.0, 3.1, 1.3] + [0, 1, 2]), 0)
    centres = rest[[3, 17, 26]]
    fields = np.exp(-((rest[None] - centres[:, None]) ** 2).sum(axis=2) / 40**2)[..., None] * rng.normal(size=(3, 1, 3))
    face = rest + 8 * np.einsum("ts,smd->tmd", sources, fields) + 0.1 * rng.normal(size=(FRAMES, 30, 3))
    return Markers(motion(FRAMES, 1).apply(face), tuple(f"m{i}" for i in range(30)), 60.0)


def test_a_clean_take_loses_nothing(clean):
    found = remove_outliers(clean)
    assert not found.wild.any()
    assert found.line() == ""
    np.testing.assert_array_equal(found.markers.positions, clean.positions)


def test_one_sample_metres_away_is_found_alone(clean):
    X = clean.positions.copy()
    X[50, 7] += [3000.0, 0, 0]
    found = remove_outliers(clean.with_positions(X))
    assert np.argwhere(found.wild).tolist() == [[50, 7]]
    assert np.isnan(found.markers.positions[50, 7]).all()
    assert "1 sample gone wild (ghosts, swapped labels): m7 (1 from frame 50)" in found.line()


def test_a_ghost_for_twenty_frames_is_found(clean):
    X = clean.positions.copy()
    X[100:120, 12] += [0.0, 20, 10]
    found = remove_outliers(clean.with_positions(X)).wild
    assert found[100:120, 12].all()
    assert found.sum() <= 22


def test_two_that_wear_each_others_label_are_found(clean):
    X = clean.positions.copy()
    X[60:120, [8, 9]] = X[60:120, [9, 8]]
    found = remove_outliers(clean.with_positions(X)).wild
    assert found[60:120, [8, 9]].all()
    assert found.sum() <= 130


def test_a_third_of_the_markers_off_together_in_one_frame_are_found(clean):
    """Neighbours that are off alike vouch for one another until those at the rim are gone."""
    X = clean.positions.copy()
    X[50, :12] += [0.0, 60, 0]
    found = remove_outliers(clean.with_positions(X)).wild
    assert np.argwhere(found).tolist() == [[50, i] for i in range(12)]


def test_it_can_be_switched_off(clean):
    X = clean.positions.copy()
    X[50, 7] += 3000.0
    assert not remove_outliers(clean.with_positions(X), OutlierConfig(times=np.inf)).wild.any()


def test_neighbours_are_the_nearest_and_never_oneself():
    head = np.zeros((3, 4, 3))
    head[:, :, 0] = [0, 10, 30, 100]
    assert nearest_markers(head, 2).tolist() == [[1, 2], [0, 2], [1, 0], [2, 1]]


def test_skin_that_moves_fast_is_no_run_of_ghosts_and_a_step_is():
    off = np.zeros((12, 3))
    off[2:9, 0] = [3, 6, 9, 12, 9, 6, 3]
    off[4:7, 1] = 12
    off[8:, 2] = [6, 9, 12, 13]
    kept = sudden_runs(off > 8, off, np.ones((12, 3), bool), OutlierConfig())
    assert not kept[:, 0].any()
    np.testing.assert_array_equal(np.flatnonzero(kept[:, 1]), [4, 5, 6])
    assert kept[9:, 2].all()
    assert sudden_runs(off > 8, off, np.ones((12, 3), bool), OutlierConfig(sudden=0.0))[:, 0].sum() == 3
    assert sudden_runs(off > 8, 5 * off, np.ones((12, 3), bool), OutlierConfig())[:, 0].sum() == 3
