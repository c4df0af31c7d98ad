"""Weights in 0..1: what viewers that clamp show is what was solved, and our readers get the signed shapes back."""

import numpy as np
import pytest

from clamped_playback import played_with_clamping
from mien.io.gltf import read_performance, read_rig, write_performance
from mien.mesh import Mesh
from mien.rig import Performance, Rig
from mien.rig.unit_weights import joined, with_unit_weights
from mien.transforms import Transform

NAMES = ("jawOpen", "frame_000123", "corrective_01", "corrective_02")


def take(weights) -> Performance:
    rng = np.random.default_rng(0)
    weights = np.array(weights, dtype=float)
    mesh = Mesh(rng.normal(0, 50, (30, 3)), rng.permutation(30).reshape(10, 3))
    rig = Rig(mesh, rng.normal(0, 2, (4, 30, 3)), NAMES)
    return Performance(rig, weights, Transform.identity(len(weights)), 30.0, np.ones(len(weights), bool))


SCAN_RIG = [[0.0, 1.98, -7.1, 0.5], [1.0, 0.2, 9.3, 0.1], [-0.1, -0.4, 0.0, -0.3]]
"""Weights as rigs of scans have them: beyond 1, and correctives of both signs."""


def test_a_file_played_with_clamping_shows_what_was_solved(tmp_path):
    before = take(SCAN_RIG)
    write_performance(tmp_path / "a.glb", before)
    np.testing.assert_allclose(played_with_clamping(tmp_path / "a.glb"), before.rig.vertices(before.weights), atol=1e-4)


def test_it_reads_back_signed(tmp_path):
    before = take(SCAN_RIG)
    write_performance(tmp_path / "a.glb", before)
    after = read_performance(tmp_path / "a.glb")
    assert after.rig.names == NAMES == read_rig(tmp_path / "a.glb").names
    np.testing.assert_allclose(after.weights[:, :2], before.weights[:, :2], atol=1e-4)
    np.testing.assert_allclose(after.rig.vertices(after.weights), before.rig.vertices(before.weights), atol=1e-4)


def test_shapes_keep_their_meaning_and_correctives_are_scaled():
    split = with_unit_weights(take(SCAN_RIG))
    more = ("jawOpen_neg", "frame_000123_neg", "frame_000123_over", "corrective_01_neg", "corrective_02_neg")
    assert split.rig.names == (*NAMES, *more)
    np.testing.assert_array_equal(split.rig.deltas[:2], take(SCAN_RIG).rig.deltas[:2])
    np.testing.assert_allclose(split.rig.deltas[2], 9.3 * take(SCAN_RIG).rig.deltas[2])
    assert split.weights.min() == 0
    assert split.weights.max() == 1
    back = joined(split.rig, split.weights)[1]
    np.testing.assert_allclose(back * [1, 1, 9.3, 1], SCAN_RIG)


def test_weights_that_lie_inside_stay_as_they_are():
    plain = take([[0.0, 1.0, 0.5, 0.2]])
    assert with_unit_weights(plain) is plain
    rounding = take([[-1e-8, 1 + 1e-8, 0.5, 0.2]])
    assert with_unit_weights(rounding).rig is rounding.rig
    np.testing.assert_array_equal(with_unit_weights(rounding).weights, [[0.0, 1.0, 0.5, 0.2]])


@pytest.mark.parametrize("name", ["jawOpen_neg", "frame_000123_over"])
def test_a_shape_that_merely_bears_such_a_name_is_no_companion(name):
    rig = take(SCAN_RIG).rig
    other = Rig(rig.neutral, np.concatenate([rig.deltas, rig.deltas[::-1][:1]]), (*NAMES, name))
    assert joined(other, np.zeros((0, 5)))[0].names == (*NAMES, name)


def test_a_performance_with_such_a_name_is_split_beside_it():
    rig = take(SCAN_RIG).rig
    other = Rig(rig.neutral, np.concatenate([rig.deltas, rig.deltas[::-1][:1]]), (*NAMES, "jawOpen_neg"))
    played = Performance(other, np.full((1, 5), -0.5), Transform.identity(1), 30.0, np.ones(1, bool))
    split = with_unit_weights(played)
    np.testing.assert_allclose(split.rig.vertices(split.weights), other.vertices(played.weights))
