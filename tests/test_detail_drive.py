import numpy as np
import pytest

from detail_patch import bent, marker_places, patch, training
from mien.clip import Markers
from mien.detail.base_mesh import BaseConfig
from mien.detail.drive import drive_by_markers, drive_by_performance, followed
from mien.detail.fit import DetailConfig, fit_detail
from mien.errors import BadInput
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector


@pytest.fixture(scope="module")
def model():
    return fit_detail(training(), DetailConfig(base=BaseConfig(vertices=0), medium_size=16, fine_size=0))


def take(labels):
    """Ten frames of shearing, which turns the best rigid fit a little, under a moving head."""
    mesh = patch()
    at = marker_places(mesh)
    still = np.stack([at.points(mesh.with_vertices(bent(mesh.vertices, 0.02 * i, 0.0))) for i in range(10)])
    turns = rotation_from_vector(np.linspace(0, 0.4, 10)[:, None] * [0.3, 1, 0.2])
    T = Transform(turns, np.linspace(0, 50, 30).reshape(10, 3))
    return still, Markers(T.apply(still), labels, 60.0)


def test_head_motion_and_order_do_not_matter(model):
    still, markers = take(model.labels)
    order = np.random.default_rng(1).permutation(25)
    mixed = Markers(markers.positions[:, order], tuple(np.array(markers.labels)[order]), 60.0)
    a, b = drive_by_markers(model, markers), drive_by_markers(model, mixed)
    np.testing.assert_allclose(a.positions, b.positions, atol=1e-9)
    spread_still = np.linalg.norm(still - still.mean(axis=1, keepdims=True), axis=2)
    spread_found = np.linalg.norm(a.positions - a.positions.mean(axis=1, keepdims=True), axis=2)
    np.testing.assert_allclose(spread_found, spread_still, atol=1e-6)


def test_a_lost_marker_follows_its_neighbours_and_is_told(model):
    _, markers = take(model.labels)
    positions = markers.positions.copy()
    positions[:, 12] = np.nan
    found = drive_by_markers(model, Markers(positions, markers.labels, 60.0))
    whole = drive_by_markers(model, markers)
    assert found.guessed[12] == 1
    assert found.guessed[:12].max() == 0
    assert np.linalg.norm(found.positions - whole.positions, axis=2).max() < 1.0


def test_other_markers_are_refused(model):
    _, markers = take(tuple(f"X{i}" for i in range(25)))
    with pytest.raises(BadInput, match="0 of the 25 markers"):
        drive_by_markers(model, markers)
    positions = take(model.labels)[1].positions.copy()
    positions[4] = np.nan
    with pytest.raises(BadInput, match="frame 4"):
        drive_by_markers(model, Markers(positions, model.labels, 60.0))


def test_a_performance_drives_as_its_markers_would(model):
    mesh = patch(21)
    delta = bent(mesh.vertices, 0.2, 0.0) - mesh.vertices
    rig = Rig(mesh, delta[None], ("squeeze",))
    performance = Performance(rig, np.linspace(0, 1, 5)[:, None], Transform.identity(5), 30.0, np.ones(5, bool))
    found = drive_by_performance(model, performance)
    expected = model.head.aligned((model.reference * [0.8, 1, 1])[None])[0]
    np.testing.assert_allclose(found.positions[-1], expected, atol=0.02)
    np.testing.assert_allclose(found.positions[0], model.reference)


def test_a_marker_that_was_never_seen_moves_as_those_round_it_do(model):
    moved = np.tile(model.reference + np.array([0.0, 0.0, 3.0]), (2, 1, 1))
    seen = np.ones(moved.shape[:2], bool)
    seen[:, 12] = False
    found = followed(model, np.where(seen[..., None], moved, np.nan), seen)
    np.testing.assert_allclose(found, moved, atol=1e-9)
