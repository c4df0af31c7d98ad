"""Labels: subjects, unlabelled trajectories, names that come twice, patterns."""

from pathlib import Path

import numpy as np
import pytest

from marker_files import FACE, NAMES, custom_c3d, refusal
from mien.io.markers import read_marker_file, read_markers
from mien.io.markers.marker_labels import is_unlabelled, main_subject, number_repeated, without_subject


def test_labels_that_come_twice_are_numbered(tmp_path):
    path = custom_c3d(tmp_path / "take.c3d", ["M0", *NAMES[:7]], np.tile(FACE, (3, 1, 1)))
    read = read_marker_file(path)
    assert read.markers.labels == ("M0_1", "M0_2", *NAMES[1:7])
    assert read.warnings == (f"{path}: 2 markers are called M0; numbered M0_1 to M0_2 in the file's order",)


@pytest.mark.parametrize(
    "label", ["", "*", "*12", "Unlabeled 3", "unlabelled_7", "Jane:*4", "uname*4", "Unnamed 2", "Unidentified12"]
)
def test_what_nobody_named(label):
    assert is_unlabelled(label)


@pytest.mark.parametrize("label", ["U12", "M000", "star*", "New 0001", "1", "chin"])
def test_what_somebody_named(label):
    assert not is_unlabelled(label)


def test_a_take_that_nobody_labelled_is_named_by_number(tmp_path):
    labels = [f"*{i + 10}" for i in range(8)]
    path = custom_c3d(tmp_path / "take.c3d", labels, np.tile(FACE, (3, 1, 1)))
    read = read_marker_file(path)
    assert read.markers.labels == tuple(f"U{i + 10}" for i in range(8))
    assert read.warnings == (
        f"{path}: 8 unlabelled trajectories are used, named by number (U10, U11, U12, U13, U14 and 3 more)",
    )


def test_pieces_of_unlabelled_trajectories_are_left_out(tmp_path):
    points = np.tile(FACE, (10, 1, 1))
    points[3:, 7] = 0
    path = custom_c3d(tmp_path / "take.c3d", [f"Unlabeled {i}" for i in range(8)], points)
    read = read_marker_file(path)
    assert read.markers.labels == tuple(f"U{i}" for i in range(7))
    assert "1 in pieces were left out" in read.warnings[0]
    points[3:, :4] = 0
    line = refusal(custom_c3d(tmp_path / "take.c3d", [f"*{i}" for i in range(8)], points))
    assert "0 labelled markers, and of 8 unlabelled trajectories 3 last through half" in line


def test_unlabelled_ones_beside_enough_labelled_are_left_out(tmp_path):
    path = custom_c3d(tmp_path / "take.c3d", [*NAMES[:6], "*1", ""], np.tile(FACE, (3, 1, 1)))
    assert read_markers(path).labels == NAMES[:6]


def test_numbers_avoid_names_that_are_taken():
    labels, lines = number_repeated(Path("a.c3d"), ["A", "A_1", "A", "B"])
    assert labels == ["A_2", "A_1", "A_3", "B"]
    assert lines == ["a.c3d: 2 markers are called A; numbered A_2 to A_3 in the file's order"]


def test_subjects():
    assert without_subject(["J:a", "J:b", "K:c"]) == ["a", "b", "c"]
    assert without_subject(["J:a", "K:a"]) == ["J:a", "K:a"]


def test_the_main_subject():
    labels = [*(f"Face:{i}" for i in range(7)), "Body:1", "Body:2"]
    assert main_subject(labels) == list(range(7))
    assert main_subject([*labels, "Body:3", "Body:4"]) == list(range(11))
    assert main_subject([]) == []


def test_a_pattern_chooses_markers(tmp_path):
    labels = [f"Face:{name}" for name in NAMES] + [f"Body:B{i}" for i in range(8)]
    points = np.concatenate([np.tile(FACE, (3, 1, 1)), np.tile(FACE * 10 + 900, (3, 1, 1))], axis=1)
    path = custom_c3d(tmp_path / "take.c3d", labels, points)
    for pattern in ("Face:*", "face:m?", "M*", "nose,M*"):
        read = read_marker_file(path, only=pattern)
        assert (read.markers.labels, read.warnings) == (NAMES, ())
    assert "no marker matches 'Hand:*'; there are Face:M0" in refusal(path, only="Hand:*")
    assert read_marker_file(path).markers.labels == NAMES
    assert len(read_marker_file(path, whole=True).markers.labels) == 16
