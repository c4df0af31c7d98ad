"""Tables with a row a frame."""

import numpy as np
import pytest

from marker_files import NAMES, take, wide_csv
from mien.io.markers import read_marker_file, read_markers


@pytest.mark.parametrize("sep", [",", ";", "\t"])
@pytest.mark.parametrize(
    "header",
    [
        lambda n, a: f"{n}_{a}",
        lambda n, a: f"{n}.{a.upper()}",
        lambda n, a: f"Jane:{n}:{a.upper()}",
        lambda n, a: f"{a}_{n}",
        lambda n, a: f"{n} {a} [mm]",
    ],
)
def test_wide_csv(tmp_path, sep, header):
    markers = take()
    back = read_markers(wide_csv(tmp_path / "take.csv", markers.positions, header, sep))
    assert back.labels == NAMES
    np.testing.assert_allclose(back.positions, markers.positions, atol=1e-5)


def test_time_gives_the_rate_and_other_columns_become_notes(tmp_path):
    extra = [("Time", [f"{t / 120:.4f}" for t in range(5)]), ("Stimulus", list("aabbb")), ("level", range(5))]
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=extra))
    assert back.rate == 120
    assert back.notes is not None
    assert list(back.notes["Stimulus"]) == list("aabbb")
    np.testing.assert_array_equal(back.notes["level"], range(5))
    assert set(back.notes) == {"Stimulus", "level"}
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=[("time_ms", range(0, 50, 10))]))
    assert (back.rate, back.notes) == (100, None)


def test_columns_that_come_twice_are_numbered(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions, lambda n, a: f"{n.replace('M1', 'M0')}_{a}")
    assert read_markers(path).labels == ("M0_1", "M0_2", *NAMES[2:])


def test_a_row_that_repeats_the_one_before_is_left_out(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions, extra=[("Frame", range(5))])
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], lines[2], *lines[3:]]))
    read = read_marker_file(path)
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=1e-5)
    assert "1 rows repeat the one before" in read.warnings[0]


def test_a_missing_row_is_a_gap(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions, extra=[("Frame", range(100, 105))])
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:3] + lines[4:]))
    np.testing.assert_array_equal(read_markers(path).seen.any(axis=1), [True, True, False, True, True])
