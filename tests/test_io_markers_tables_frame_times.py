"""Frame numbers and times -> places and rate."""

import numpy as np
import pytest

from marker_files import refusal, take, wide_csv
from mien.io.markers import read_marker_file, read_markers
from mien.io.markers.tables.frame_times import frames_of_numbers, frames_of_times, rate_of


def test_frame_numbers_left_out_become_gaps(tmp_path):
    extra = [("Frame", [7, 8, 10, 11, 12]), ("mood", list("abcde"))]
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=extra))
    assert back.positions.shape[0] == 6
    assert not back.seen[2].any()
    np.testing.assert_allclose(back.positions[3], take().positions[2], atol=1e-5)
    assert back.notes is not None
    assert list(back.notes["mood"]) == ["a", "b", "", "c", "d", "e"]


def test_every_second_frame_is_a_take_without_gaps(tmp_path):
    extra = [("Frame", [2, 4, 6, 8, 10]), ("Time", [t / 60 for t in range(5)])]
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=extra))
    assert back.positions.shape[0] == 5
    assert back.rate == 60


@pytest.mark.parametrize(("per_second", "name"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")])
def test_times_that_cannot_be_seconds(tmp_path, per_second, name):
    extra = [("Time", [f"{1000 + t / 60 * per_second:.0f}" for t in range(5)])]
    read = read_marker_file(wide_csv(tmp_path / "take.csv", take().positions, extra=extra))
    np.testing.assert_allclose(read.markers.rate, 60, rtol=0.02)
    assert name in read.warnings[0]


def test_clock_times(tmp_path):
    extra = [("Time", [f"00:01:{10 + t / 50:06.3f}" for t in range(5)])]
    assert read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=extra)).rate == 50


def test_numbers_too_large_to_count(tmp_path):
    assert "renumber or split" in refusal(
        wide_csv(tmp_path / "take.csv", take().positions, extra=[("Frame", [1, 2, 3, 4, "1e300"])])
    )


def test_places(tmp_path):
    assert frames_of_numbers(tmp_path, np.array([10.0, 12, 16])).tolist() == [0, 1, 3]
    assert frames_of_numbers(tmp_path, np.array([0.5, 1.5])).tolist() == [0, 1]
    assert frames_of_times(tmp_path, np.array([0, 0.01, 0.02, 0.05])).tolist() == [0, 1, 2, 5]
    assert frames_of_times(tmp_path, np.array([0, 1e-300, 1e300])).tolist() == [0, 1, 2]


def test_rate_of():
    times = np.round(np.arange(9) / 59.94, 3)
    assert rate_of(times, np.arange(9)) == 60
    np.testing.assert_allclose(rate_of(np.arange(9) / 59.94, np.arange(9)), 59.94)
    assert rate_of(np.zeros(4), np.arange(4)) is None
