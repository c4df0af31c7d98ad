import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.viewer.marker_overlay import markers_in_world, quarter_turns
from studio_things import RATE, nodding


def worn(performance, turn):
    some = performance.rig.neutral.vertices[:, 2] > 120
    points = np.stack([mesh.vertices[some][::7] for mesh in performance.meshes(world=True)])
    return points, Markers(points @ turn, tuple(f"m{i}" for i in range(points.shape[1])), RATE)


def test_there_are_24_turns_and_the_first_does_nothing():
    turns = quarter_turns()
    assert len({R.tobytes() for R in turns}) == 24
    np.testing.assert_array_equal(turns[0], np.eye(3))


@pytest.mark.parametrize("number", [0, 5, 11])
def test_markers_of_any_lab_lie_on_the_face(number):
    performance = nodding(7)
    points, take = worn(performance, quarter_turns()[number])
    np.testing.assert_allclose(markers_in_world(take, performance), points, atol=1e-9)


def test_markers_of_another_take_are_refused():
    performance = nodding(7)
    _, take = worn(performance, np.eye(3))
    with pytest.raises(BadInput, match="nowhere near the face"):
        markers_in_world(Markers(take.positions + 900.0, take.labels, RATE), performance)
