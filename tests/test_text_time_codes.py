"""Rows to frames by their clocks, by hand."""

import numpy as np
import pytest

from mien.text.time_codes import read_clock


def codes(frames, rate: int, mark: str = ":") -> list[str]:
    return [f"00:{f // rate // 60:02d}:{f // rate % 60:02d}{mark}{f % rate:02d}.000" for f in frames]


def test_frames_of_the_second_tell_the_rate():
    clock = read_clock(codes(range(90), 30), None)
    np.testing.assert_array_equal(clock.frames, np.arange(90))
    assert (clock.rate, clock.notes) == (30.0, ())


def test_a_row_that_is_missing_leaves_its_frame_open_and_is_told():
    clock = read_clock(codes([*range(40), *range(45, 90)], 30), None)
    assert clock.frames[40] == 45
    assert clock.notes == ("5 frames have no row; they hold the last value",)


def test_a_time_that_stands_twice_is_told():
    clock = read_clock(codes([0, 1, 1, *range(2, 60)], 30), None)
    np.testing.assert_array_equal(clock.frames[:4], [0, 1, 1, 2])
    assert clock.notes == ("1 rows repeat a time; the last of each is kept",)


def test_midnight_is_crossed():
    before, after = [f"23:59:59:{f:02d}" for f in range(30)], [f"00:00:00:{f:02d}" for f in range(30)]
    np.testing.assert_array_equal(read_clock(before + after, None).frames, np.arange(60))


def test_drop_frame_codes_skip_two_numbers_a_minute_but_no_frame():
    seen = [*codes(range(1700, 1800), 30, ";"), *codes(range(1802, 1900), 30, ";")]
    clock = read_clock(seen, None)
    np.testing.assert_array_equal(clock.frames, np.arange(len(seen)))
    assert clock.rate == pytest.approx(30000 / 1001)


@pytest.mark.parametrize(("unit", "rate"), [(1.0, 25), (1e3, 60), (1e6, 30000 / 1001)])
def test_seconds_in_any_unit(unit, rate):
    clock = read_clock([f"{5 * unit + t * unit / rate:.6f}" for t in range(100)], None)
    np.testing.assert_array_equal(clock.frames, np.arange(100))
    assert clock.rate == pytest.approx(rate)


def test_a_rate_that_is_told_is_believed():
    assert read_clock(codes(range(90), 30), 24.0).rate == 24.0


@pytest.mark.parametrize("text", [["a", "b", "c"], ["", "", ""]])
def test_without_a_clock_frames_follow_one_another(text):
    clock = read_clock(text, None)
    np.testing.assert_array_equal(clock.frames, [0, 1, 2])
    assert clock.rate == 60.0
    assert "cannot be read" in clock.notes[0]


@pytest.mark.parametrize(
    "form", ["2026-01-02T10:00:{:09.6f}Z", "2026-01-02 10:00:{:09.6f}", "2026-01-02T10:00:{:.4f}+02:00"]
)
def test_clocks_with_a_date(form):
    clock = read_clock([form.format(t / 25) for t in range(50)], None)
    np.testing.assert_array_equal(clock.frames, np.arange(50))
    assert clock.rate == 25


def test_whole_numbers_one_by_one_count_frames():
    clock = read_clock([str(t) for t in (*range(7, 40), *range(43, 60))], None)
    assert clock.rate == 60
    np.testing.assert_array_equal(clock.frames[[0, 32, 33]], [0, 32, 36])
    assert "counts frames" in clock.notes[0]
    assert read_clock([str(t) for t in range(50)], 24.0).rate == 24
