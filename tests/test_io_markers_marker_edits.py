"""Names and bad ranges beside a take."""

import json

import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.io.markers import read_marker_file, read_markers, write_c3d
from mien.io.markers.marker_edits import (
    MarkerEdits,
    apply_marker_edits,
    marker_edits_beside,
    read_marker_edits,
    write_marker_edits,
)


@pytest.fixture
def take(tmp_path):
    rng = np.random.default_rng(0)
    positions = 60 * rng.standard_normal((1, 8, 3)) + 0.1 * rng.standard_normal((20, 8, 3))
    path = tmp_path / "take.c3d"
    write_c3d(path, Markers(positions, tuple(f"M{m}" for m in range(8)), 10.0))
    return path


def test_every_reading_heeds_names_and_bad_ranges(take):
    edits = MarkerEdits({"M2": "chin", "gone": "x"}, {"M5": ((0.5, 0.7),)})
    write_marker_edits(take, edits)
    assert read_marker_edits(take) == edits
    plain, file = read_marker_file(take, as_filed=True), read_marker_file(take)
    assert file.markers.labels == ("M0", "M1", "chin", *plain.markers.labels[3:])
    unseen = np.isnan(file.markers.positions).all(axis=2)
    assert np.argwhere(unseen).tolist() == [[5, 5], [6, 5], [7, 5]]
    np.testing.assert_array_equal(file.markers.positions[~unseen], plain.markers.positions[~unseen])
    assert "2 markers named, 1 ranges bad" in file.warnings[-1]
    write_marker_edits(take, MarkerEdits())
    assert not marker_edits_beside(take).exists()
    assert read_markers(take).labels == plain.markers.labels


def test_two_markers_of_one_name_are_refused(take):
    with pytest.raises(BadInput, match="two markers would be called M1"):
        apply_marker_edits(read_markers(take), MarkerEdits({"M0": "M1"}), "here")


@pytest.mark.parametrize("told", ["[]", "{", '{"names": {"M0": ""}}', '{"bad": {"M0": [{"from": 1}]}}'])
def test_a_broken_file_is_named(take, told):
    marker_edits_beside(take).write_text(told)
    with pytest.raises(BadInput, match=r"take\.markers\.json"):
        read_markers(take)


def test_names_go_both_ways_at_once(take):
    marker_edits_beside(take).write_text(json.dumps({"names": {"M0": "M1", "M1": "M0"}}))
    assert read_markers(take).labels[:2] == ("M1", "M0")
