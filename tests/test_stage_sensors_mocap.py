"""Markers on the performer: exact where no fault is asked for, faulty as much as asked where one is."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.markers import read_markers, write_c3d
from mien.stage import HeadMotion, MocapConfig, make_performer, marker_layout, perform, random_performance
from mien.stage.sensors.mocap import HARD_MOCAP, bursts, head_motion
from mien.transforms import vector_from_rotation

CLEAN = MocapConfig(jitter=0.0, dropouts=0.0, standoff=(0.0, 0.0), standoff_sd=0.0)


@pytest.fixture(scope="module")
def performer():
    return make_performer(1)


@pytest.fixture(scope="module")
def script():
    return random_performance(60.0, 4.0, seed=1)


def test_the_truth_reproduces_faultless_markers(performer, script):
    take = perform(performer, script.weights, 60.0, marker_layout(performer, 30), CLEAN)
    for t in (0, 100, 239):
        mesh = performer.mesh(script.weights[t])
        on_skin = take.truth.T_lab_face[t].apply(take.truth.attachment.points(mesh))
        np.testing.assert_allclose(take.markers.positions[t], on_skin, atol=1e-9)


def test_stand_off_is_the_distance_from_the_skin(performer, script):
    config = MocapConfig(jitter=0.0, dropouts=0.0, standoff=(4.0, 4.0), standoff_sd=0.2)
    take = perform(performer, script.weights[:40], 60.0, marker_layout(performer, 50), config)
    skin = take.truth.T_lab_face[7].apply(take.truth.attachment.points(performer.mesh(script.weights[7])))
    np.testing.assert_allclose(np.linalg.norm(take.markers.positions[7] - skin, axis=1), take.truth.standoff, atol=1e-9)
    assert 3.8 < take.truth.standoff.mean() < 4.2


def test_jitter_and_drop_outs_are_as_asked(performer):
    weights = np.zeros((500, 52))
    config = MocapConfig(jitter=0.3, dropouts=0.05)
    take = perform(performer, weights, 60.0, marker_layout(performer, 30), config)
    noise = (take.markers.positions - take.truth.clean)[take.markers.seen]
    np.testing.assert_allclose(noise.std(), 0.3, rtol=0.04)
    np.testing.assert_allclose(1 - take.markers.seen.mean(), 0.05, atol=0.02)


def test_drop_outs_come_in_bursts():
    away = bursts(20000, 10, 0.1, 8.0, np.random.default_rng(0))
    runs = np.count_nonzero(np.diff(away.astype(int), axis=0) == 1)
    np.testing.assert_allclose(away.sum() / runs, 8.0, rtol=0.15)
    assert not bursts(50, 3, 0.0, 8.0, np.random.default_rng(0)).any()


def test_lost_swapped_and_ghosted_labels(performer):
    weights, layout = np.zeros((300, 52)), marker_layout(performer, 16)
    lost = perform(performer, weights, 60.0, layout, MocapConfig(dropouts=0.0, lost=3))
    assert ((~lost.markers.seen).mean(axis=0) > 0.2).sum() == 3
    wrong = perform(performer, weights, 60.0, layout, MocapConfig(dropouts=0.0, jitter=0.0, swaps=2, ghosts=3))
    off = np.linalg.norm(wrong.markers.positions - wrong.truth.clean, axis=2)
    assert np.count_nonzero(off.max(axis=0) > 5) >= 3
    assert (off < 1e-9).mean() > 0.7


def test_layouts_are_spread_and_keep_off_lids_and_lips(performer):
    for count in (16, 31, 200):
        layout = marker_layout(performer, count)
        points = layout.attachment.points(performer.neutral)
        assert len(points) == len(set(layout.labels)) == count
        distance = np.linalg.norm(points[:, None] - points[None], axis=2) + 1e9 * np.eye(count)
        assert distance.min() > 40 / np.sqrt(count) * 0.4
        for side, lids in performer.lids.items():
            margin = np.concatenate(lids.points(performer.neutral.vertices))
            assert np.linalg.norm(points[:, None] - margin, axis=2).min() > 2.0, side


def test_the_head_moves_smoothly_and_as_far_as_asked(performer):
    T = head_motion(6000, 120.0, HeadMotion(), np.random.default_rng(0))
    turned = np.linalg.norm(vector_from_rotation(T.rotation), axis=1)
    assert 0.15 < turned.max() < 0.6
    assert np.linalg.norm(np.diff(T.translation, axis=0), axis=1).max() < 4
    still = perform(
        performer, np.zeros((5, 52)), 120.0, marker_layout(performer, 16),
        MocapConfig(head=HeadMotion(rotation=0.0, translation=0.0), jitter=0.0, dropouts=0.0),
    )  # fmt: skip
    assert np.ptp(still.markers.positions, axis=0).max() < 1e-9


def test_the_lab_is_as_upright_as_asked(performer):
    for up, axis in (("+Y", 1), ("+Z", 2), ("+X", 0)):
        take = perform(performer, np.zeros((50, 52)), 60.0, marker_layout(performer, 16), MocapConfig(up=up))
        assert take.truth.T_lab_face.rotation[:, axis, 1].mean() > 0.8


def test_takes_are_decided_by_their_seed(performer, script):
    layout = marker_layout(performer, 16)
    a, b, c = (perform(performer, script.weights[:20], 60.0, layout, seed=s).markers.positions for s in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert np.nanmax(np.abs(a - c)) > 1


def test_a_take_survives_c3d(performer, script, tmp_path):
    take = perform(performer, script.weights, 60.0, marker_layout(performer, 30), MocapConfig(dropouts=0.1))
    write_c3d(tmp_path / "take.c3d", take.markers)
    back = read_markers(tmp_path / "take.c3d")
    assert back.labels == take.markers.labels
    assert back.rate == 60.0
    np.testing.assert_array_equal(back.seen, take.markers.seen)
    np.testing.assert_allclose(back.positions, take.markers.positions, atol=1e-3)


@pytest.mark.parametrize(
    ("change", "word"),
    [({"dropouts": 1.5}, "dropouts"), ({"up": "Q"}, "up"), ({"lost": 99}, "lost")],
)
def test_impossible_stages_are_refused(performer, change, word):
    with pytest.raises(BadInput, match=word):
        perform(performer, np.zeros((5, 52)), 60.0, marker_layout(performer, 16), MocapConfig(**change))


def test_wrong_widths_and_counts_are_refused(performer):
    with pytest.raises(BadInput, match="weights"):
        perform(performer, np.zeros((5, 51)), 60.0, marker_layout(performer, 16))
    with pytest.raises(BadInput, match="count"):
        marker_layout(performer, 3)


def test_unlabelled_trajectories_come_and_go_off_the_markers(performer):
    layout = marker_layout(performer, 16)
    take = perform(performer, np.zeros((300, 52)), 60.0, layout, MocapConfig(dropouts=0.0, unlabelled=4))
    assert take.markers.labels[16:] == ("*1", "*2", "*3", "*4")
    strays = take.markers.positions[:, 16:]
    seen = ~np.isnan(strays).any(axis=2)
    assert (seen.any(axis=0) & ~seen.all(axis=0)).all()
    nearest = np.linalg.norm(strays[:, :, None] - take.truth.clean[:, None], axis=3).min(axis=2)
    assert np.nanmax(nearest) > 10
    plain = perform(performer, np.zeros((300, 52)), 60.0, layout, MocapConfig(dropouts=0.0))
    np.testing.assert_array_equal(take.markers.positions[:, :16], plain.markers.positions)


def test_a_hard_take_has_every_fault(performer):
    take = perform(performer, np.zeros((600, 52)), 60.0, marker_layout(performer, 30), HARD_MOCAP)
    off = np.linalg.norm(take.markers.positions[:, :30] - take.truth.clean, axis=2)
    assert np.nanmax(off) > 10
    assert (np.isnan(off).mean(axis=0) > 0.2).sum() >= 2
    assert take.markers.labels[-1] == "*3"
