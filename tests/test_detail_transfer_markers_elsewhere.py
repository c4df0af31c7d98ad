from dataclasses import replace

import numpy as np
import pytest

from detail_patch import bent, marker_places, patch, training
from mien.clip import Markers
from mien.detail.base_mesh import BaseConfig
from mien.detail.drive import drive_by_markers
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.transfer.markers_elsewhere import place_markers
from mien.errors import BadInput
from mien.mesh import closest_point
from mien.transforms import Transform, rotation_from_vector


@pytest.fixture(scope="module")
def model():
    return fit_detail(training(), DetailConfig(base=BaseConfig(vertices=0), medium_size=16, fine_size=0))


def take(at, labels):
    """Five frames of squeezing under a head that turns; the first is neutral."""
    mesh = patch()
    still = np.stack([at.points(mesh.with_vertices(bent(mesh.vertices, 0.04 * i, 0.0))) for i in range(5)])
    turns = rotation_from_vector(np.linspace(0, 0.2, 5)[:, None] * [0.3, 1, 0.2])
    return Markers(Transform(turns, np.linspace(0, 40, 15).reshape(5, 3)).apply(still), labels, 60.0)


def test_markers_of_other_places_and_number_drive_as_the_training_s_would(model):
    mesh = patch()
    own = drive_by_markers(model, take(marker_places(mesh), model.labels))
    other = closest_point(mesh, marker_places(mesh, 7).points(mesh)).attachment()
    names = tuple(f"M{i}" if i < 6 else f"X{i}" for i in range(49))
    shifted = take(other, names)
    with pytest.raises(BadInput, match="--place"):
        drive_by_markers(model, shifted)
    same = take(marker_places(mesh), model.labels)
    found = place_markers(model, same, 0).drive(same)
    np.testing.assert_allclose(found.positions, own.positions, atol=0.05)
    unnamed = replace(shifted, labels=tuple(f"Q{i}" for i in range(49)))
    found = place_markers(model, unnamed, 0).drive(unnamed)
    assert found.positions.shape == own.positions.shape


def test_a_frame_that_is_not_there_is_refused(model):
    markers = take(marker_places(patch()), model.labels)
    with pytest.raises(BadInput, match="frame 9 of 5"):
        place_markers(model, markers, 9)
    positions = markers.positions.copy()
    positions[0, 3:] = np.nan
    with pytest.raises(BadInput, match="shows 3 markers"):
        place_markers(model, replace(markers, positions=positions), 0)
