"""From a raw take to markers: what is refused, what is told."""

from pathlib import Path

import numpy as np
import pytest

from marker_files import NAMES, custom_c3d, refusal, take, wide_csv
from mien.clip import Markers
from mien.io.markers import read_marker_file, read_markers, write_c3d
from mien.io.markers.marker_file import gaps_to_nan

REAL = Path(__file__).resolve().parents[2] / "shared/data/markers16"


def test_missing_file_and_unknown_suffix(tmp_path):
    assert "no such file" in refusal(tmp_path / "take.c3d")
    (tmp_path / "take.fbx").write_text("x")
    assert ".c3d .trc .csv" in refusal(tmp_path / "take.fbx")


def test_all_empty_frames_are_refused(tmp_path):
    path = wide_csv(tmp_path / "take.csv", np.full((4, 8, 3), np.nan))
    assert "all 4 frames are empty" in refusal(path)
    path = custom_c3d(tmp_path / "take.c3d", list(NAMES), np.zeros((4, 8, 3)))
    assert "all 4 frames are empty" in refusal(path)


def test_fewer_than_six_markers_are_refused(tmp_path):
    assert "only 5 marker(s)" in refusal(wide_csv(tmp_path / "take.csv", take().positions[:, :5]))
    write_c3d(tmp_path / "take.c3d", Markers(take().positions[:, :5], NAMES[:5], 60.0))
    assert "at least 6" in refusal(tmp_path / "take.c3d")
    positions = take().positions
    positions[:, :3] = np.nan
    assert "only 5 marker(s)" in refusal(wide_csv(tmp_path / "take.csv", positions))


def test_a_marker_never_seen_is_told(tmp_path):
    positions = take().positions
    positions[:, 3] = np.nan
    read = read_marker_file(wide_csv(tmp_path / "take.csv", positions))
    assert read.warnings[0].endswith("never seen: M3")


def test_markers_all_in_one_place_are_refused(tmp_path):
    assert "apart" in refusal(wide_csv(tmp_path / "take.csv", np.ones((3, 8, 3))))


def test_the_rate_by_argument_and_by_default(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions)
    assert read_markers(path).rate == 30
    assert "30 frames/s assumed" in read_marker_file(path).warnings[-1]
    assert read_markers(path, rate=240.0).rate == 240
    assert "cannot be" in refusal(path, rate=-1.0)


@pytest.mark.data
@pytest.mark.parametrize(("subject", "frames", "dot"), [("01", 1714, 0.04328), ("02", 1692, 0.05097)])
def test_a_real_take(subject, frames, dot):
    path = REAL / f"Subject_{subject}.csv"
    if not path.exists():
        pytest.skip(f"{path} is not there")
    read = read_marker_file(path)
    assert read.unit_source == "guessed"
    assert read.markers.positions.shape == (frames, 16, 3)
    assert read.markers.notes is not None
    assert "posed_happy" in read.markers.notes["Stimulustype"]
    assert 0.4 < read.markers.seen.mean() < 0.6
    np.testing.assert_allclose(read.unit_mm, 8 / dot, rtol=0.03)
    assert read_marker_file(path, unit=f"{8 / dot:.3f}").unit_source == "argument"


def test_far_away_is_a_gap():
    positions = take().positions
    positions[0, 0, 1] = 1e30
    positions[0, 1] = 0
    seen = np.isfinite(gaps_to_nan(positions)).all(axis=2)
    np.testing.assert_array_equal(seen[0], [False, False, *[True] * 6])


@pytest.mark.parametrize("written", [0.0, -9999.0, 9999999.0, 999.0])
def test_the_same_number_of_zeros_or_nines_in_all_three_is_a_gap(written):
    positions = np.array([[[written] * 3, [written, 1.0, written], [998.0] * 3]])
    np.testing.assert_array_equal(np.isnan(gaps_to_nan(positions)).all(axis=2), [[True, False, False]])
