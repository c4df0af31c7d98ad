"""What really happened: in the bundled topology, in chunks, of performers and skins."""

import numpy as np
import pytest

from mien.faces import load_face
from mien.stage import make_performer
from mien.stage.truth import Truth
from mien.transforms import Transform


@pytest.fixture(scope="module")
def truth():
    actor = make_performer(3)
    weights = np.zeros((5, len(actor.names)))
    weights[3:, actor.names.index("jawOpen")] = 0.5
    still = Transform(np.tile(np.eye(3), (5, 1, 1)), np.zeros((5, 3)))
    return Truth(actor, weights, still, 30.0)


def test_the_neutral_has_no_expression(truth):
    assert truth.neutral.vertices.shape == load_face().rig.neutral.vertices.shape
    np.testing.assert_allclose(truth.vertices(np.array([0]))[0], truth.neutral.vertices, atol=1e-9)
    assert np.abs(truth.vertices(np.array([4]))[0] - truth.neutral.vertices).max() > 5


def test_a_stream_is_the_frames_in_chunks(truth):
    frames = np.array([4, 0, 3])
    numbers, chunks = zip(*truth.stream(frames, chunk=2), strict=True)
    np.testing.assert_array_equal(np.concatenate(numbers), frames)
    np.testing.assert_allclose(np.concatenate(chunks), truth.vertices(frames), atol=1e-9)
    assert len(truth) == 5
