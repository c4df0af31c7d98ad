"""The blendshape rig by hand."""

import numpy as np
import pytest

from mien.mesh import Mesh
from mien.rig import Rig

MESH = Mesh(np.eye(3), np.array([[0, 1, 2]]))
RIG = Rig(MESH, np.stack([np.full((3, 3), 2.0), np.diag([1.0, 0, 0])]), ("up", "out"))


def test_vertices_are_the_neutral_and_the_weighted_shapes():
    np.testing.assert_array_equal(RIG.vertices(np.array([0.5, 0.0])), np.eye(3) + 1)
    np.testing.assert_array_equal(RIG.mesh(np.array([0.0, 3.0])).vertices, np.diag([4.0, 1, 1]))


def test_a_batch_is_its_frames():
    weights = np.random.default_rng(0).random((2, 4, 2))
    batch = RIG.vertices(weights)
    assert batch.shape == (2, 4, 3, 3)
    np.testing.assert_allclose(batch[1, 2], RIG.vertices(weights[1, 2]))


def test_names_are_found_and_others_named():
    assert RIG.index("out") == 1
    with pytest.raises(KeyError, match="no shape named 'in'; there are up, out"):
        RIG.index("in")


def test_other_shapes_keep_names():
    other = RIG.with_shapes(MESH, -RIG.deltas)
    assert other.names == RIG.names
    np.testing.assert_array_equal(other.vertices(np.ones(2)), 2 * np.eye(3) - RIG.vertices(np.ones(2)))


@pytest.mark.parametrize(
    ("deltas", "names", "message"),
    [
        (np.zeros((2, 3, 3)), ("a", "a"), "expected 2 different ones"),
        (np.zeros((2, 3, 3)), ("a",), "expected 2 different ones"),
        (np.zeros((1, 4, 3)), ("a",), r"expected \(shapes, 3, 3\)"),
    ],
)
def test_what_does_not_fit_is_refused(deltas, names, message):
    with pytest.raises(ValueError, match=message):
        Rig(MESH, deltas, names)
