"""Where a C3D file keeps its frames: counts that contradict each other, and files that are cut off."""

import struct

import numpy as np

from marker_files import FACE, c3d_bytes, record, refusal, take
from mien.io.markers import read_markers, write_c3d

POSITIONS = FACE + np.arange(5.0)[:, None, None]


def read(data: bytes, tmp_path) -> np.ndarray:
    (tmp_path / "take.c3d").write_bytes(data)
    return read_markers(tmp_path / "take.c3d").positions


def changed(data: bytes, at: int, value: int) -> bytes:
    return data[:at] + struct.pack("<H", value) + data[at + 2 :]


def test_cut_off_c3d_is_refused(tmp_path):
    write_c3d(tmp_path / "take.c3d", take(frames=60))
    data = (tmp_path / "take.c3d").read_bytes()
    (tmp_path / "take.c3d").write_bytes(data[: len(data) - 2000])
    assert "cut off" in refusal(tmp_path / "take.c3d")


def test_a_c3d_cut_off_anywhere_is_refused(tmp_path):
    write_c3d(tmp_path / "take.c3d", take(), up="+Z")
    data = (tmp_path / "take.c3d").read_bytes()
    frames_end = 2 * 512 + 5 * 8 * 16
    assert not any(data[frames_end:])
    for size in (*range(500, 1600, 13), *range(1600, frames_end, 97)):
        (tmp_path / "cut.c3d").write_bytes(data[:size])
        refusal(tmp_path / "cut.c3d")


def test_a_c3d_whose_counts_disagree_is_refused(tmp_path):
    write_c3d(tmp_path / "take.c3d", take())
    data = bytearray((tmp_path / "take.c3d").read_bytes())
    data[2] = 9
    (tmp_path / "take.c3d").write_bytes(data)
    assert "9 points in its header, 8 in POINT:USED" in refusal(tmp_path / "take.c3d")


def test_the_number_of_frames_that_fits_the_file_counts(tmp_path):
    """The header promises nine, POINT:FRAMES five, and five are there."""
    frames = record(1, "FRAMES", struct.pack("<bBh", 2, 0, 5))
    data = changed(c3d_bytes(POSITIONS, extra=frames), 8, 9)
    np.testing.assert_allclose(read(data, tmp_path), POSITIONS, rtol=1e-6)


def test_the_number_of_points_that_fills_the_file_counts(tmp_path):
    """100 frames leave no doubt that the header's nine points are eight."""
    positions = np.tile(FACE, (100, 1, 1))
    np.testing.assert_allclose(read(changed(c3d_bytes(positions), 2, 9), tmp_path), positions, rtol=1e-6)


def test_frames_need_not_start_at_one(tmp_path):
    data = changed(changed(c3d_bytes(POSITIONS), 6, 101), 8, 105)
    np.testing.assert_allclose(read(data, tmp_path), POSITIONS, rtol=1e-6)


def test_a_count_that_ran_over_is_the_files_length(tmp_path):
    """65,540 frames: a 16-bit count starts again at 4."""
    positions = np.tile(FACE[:6], (65_540, 1, 1))
    data = c3d_bytes(positions)
    assert struct.unpack_from("<H", data, 8) == (4,)
    assert len(read(data, tmp_path)) == 65_540


def test_without_any_count_the_files_length_counts_and_its_filling_does_not(tmp_path):
    """The header's 65,535 says nothing; five frames leave room for three more of zeros in the last block."""
    data = changed(c3d_bytes(POSITIONS), 8, 65_535)
    assert (len(data) - 1024) // 128 == 8
    np.testing.assert_allclose(read(data, tmp_path), POSITIONS, rtol=1e-6)


def test_trial_fields_hold_the_long_count(tmp_path):
    low, high = 65_540 % 65_536, 1
    trial = record(-5, "TRIAL") + record(5, "ACTUAL_START_FIELD", struct.pack("<bBBHH", 2, 1, 2, 1, 0))
    trial += record(5, "ACTUAL_END_FIELD", struct.pack("<bBBHH", 2, 1, 2, low, high))
    positions = np.tile(FACE[:6], (65_540, 1, 1))
    data = changed(c3d_bytes(positions, extra=trial), 8, 65_535)
    assert len(read(data + bytes(2000), tmp_path)) == 65_540


def test_data_start_of_either_place(tmp_path):
    data = c3d_bytes(POSITIONS)
    np.testing.assert_allclose(read(changed(data, 16, 0), tmp_path), POSITIONS, rtol=1e-6)
    at = data.index(b"DATA_START") + len("DATA_START") + 4
    np.testing.assert_allclose(read(changed(data, at, 0), tmp_path), POSITIONS, rtol=1e-6)


def test_the_cut_off_line_says_how_many_frames_are_there(tmp_path):
    data = c3d_bytes(np.tile(FACE, (60, 1, 1)))
    (tmp_path / "take.c3d").write_bytes(data[: 1024 + 41 * 128 + 30])
    assert "promises 60 frames, 41 are there" in refusal(tmp_path / "take.c3d")


def test_a_header_whose_frames_nobody_filled_in_says_nothing(tmp_path):
    data = bytearray(c3d_bytes(np.tile(FACE, (20, 1, 1))))
    data[6:10] = bytes(4)
    (tmp_path / "take.c3d").write_bytes(data)
    assert len(read_markers(tmp_path / "take.c3d").positions) == 20
