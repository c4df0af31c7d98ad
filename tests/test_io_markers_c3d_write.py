"""C3D out: round trips, what another library sees, more frames than the header can count."""

from dataclasses import replace

import ezc3d
import numpy as np
import pytest

from marker_files import FACE, NAMES, refusal, take
from mien.clip import Markers
from mien.errors import BadInput
from mien.io.markers import read_marker_file, read_markers, write_c3d


def test_c3d_round_trip(tmp_path):
    markers = take()
    write_c3d(tmp_path / "take.c3d", markers, up="+Y")
    back = read_marker_file(tmp_path / "take.c3d")
    np.testing.assert_allclose(back.markers.positions, markers.positions, rtol=1e-6)
    assert back.markers.labels == NAMES
    assert back.markers.rate == 60
    assert (back.unit_mm, back.unit_source, back.up_source, back.warnings) == (1.0, "file", "file", ())


def test_written_c3d_is_what_ezc3d_sees(tmp_path):
    markers = take()
    write_c3d(tmp_path / "take.c3d", markers)
    content = ezc3d.c3d(str(tmp_path / "take.c3d"))
    assert content["parameters"]["POINT"]["LABELS"]["value"] == list(NAMES)
    assert content["parameters"]["POINT"]["UNITS"]["value"] == ["mm"]
    points = content["data"]["points"][:3].transpose(2, 1, 0)
    np.testing.assert_allclose(points, markers.positions, rtol=1e-6)
    assert content["data"]["meta_points"]["residuals"][0, 2, 1] == -1


@pytest.mark.parametrize("up", ["+X", "-X", "+Y", "-Y", "+Z", "-Z"])
def test_c3d_up_axis_is_turned_to_plus_y(tmp_path, up):
    """Whatever axis the lab calls up, that coordinate comes back as y, and handedness stays."""
    markers = take()
    write_c3d(tmp_path / "take.c3d", markers, up=up)
    back = read_markers(tmp_path / "take.c3d").positions
    sign = 1 if up[0] == "+" else -1
    np.testing.assert_allclose(back[..., 1], sign * markers.positions[..., "XYZ".index(up[1])], rtol=1e-5, atol=1e-5)
    a, b = (p[0, 1:4] - p[0, 0] for p in (back, markers.positions))
    np.testing.assert_allclose(np.linalg.det(a), np.linalg.det(b), rtol=1e-4)


def test_c3d_without_up_axis_stays_as_it_is(tmp_path):
    write_c3d(tmp_path / "take.c3d", take())
    assert read_marker_file(tmp_path / "take.c3d").up_source == "unknown"


def test_more_than_255_points(tmp_path):
    """C3D keeps at most 255 names in LABELS and puts the rest in LABELS2."""
    rng = np.random.default_rng(1)
    positions = FACE[rng.integers(0, 8, 300)] + rng.normal(0, 3, (2, 300, 3))
    names = tuple(f"P{i}" for i in range(300))
    write_c3d(tmp_path / "take.c3d", Markers(positions, names, 120.0))
    back = read_markers(tmp_path / "take.c3d")
    assert back.labels == names
    np.testing.assert_allclose(back.positions, positions, rtol=1e-5, atol=1e-5)


def test_a_failed_write_leaves_the_old_file(tmp_path):
    write_c3d(tmp_path / "take.c3d", take())
    before = (tmp_path / "take.c3d").read_bytes()
    with pytest.raises(Exception):  # noqa: B017, PT011
        write_c3d(tmp_path / "take.c3d", replace(take(), rate="fast"))  # pyright: ignore[reportArgumentType]
    assert (tmp_path / "take.c3d").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["take.c3d"]
    with pytest.raises(BadInput, match="does not exist"):
        write_c3d(tmp_path / "nowhere/take.c3d", take())


def test_more_frames_than_the_header_can_count(tmp_path):
    """The header's count ends at 65,535; TRIAL and POINT:LONG_FRAMES hold the true one, and nothing is lost."""
    frames = 70_000
    positions = np.tile(FACE, (frames, 1, 1))
    positions[:, 0, 0] += np.linspace(0, 20, frames)
    positions[69_999, 3] = np.nan
    write_c3d(tmp_path / "take.c3d", Markers(positions, NAMES, 240.0))
    back = read_markers(tmp_path / "take.c3d")
    assert back.positions.shape == (frames, 8, 3)
    np.testing.assert_allclose(back.positions, positions, rtol=1e-6)


def test_long_and_foreign_names_come_back(tmp_path):
    names = ("Stirn_außen_links" * 6, "目", *NAMES[2:])
    write_c3d(tmp_path / "take.c3d", Markers(take().positions, names, 59.94))
    back = read_markers(tmp_path / "take.c3d")
    assert back.labels == names
    np.testing.assert_allclose(back.rate, 59.94, rtol=1e-6)


def test_names_that_need_several_lists(tmp_path):
    """A list is at most 32,000 bytes long, so 300 names of 120 letters need two."""
    rng = np.random.default_rng(2)
    names = tuple(f"{i:0120d}" for i in range(300))
    positions = FACE[rng.integers(0, 8, 300)] + rng.normal(0, 3, (2, 300, 3))
    write_c3d(tmp_path / "take.c3d", Markers(positions, names, 120.0))
    assert read_markers(tmp_path / "take.c3d").labels == names


def test_names_beyond_what_c3d_holds_are_refused(tmp_path):
    names = tuple(f"{i:0250d}" for i in range(600))
    with pytest.raises(BadInput, match="too long for C3D"):
        write_c3d(tmp_path / "take.c3d", Markers(np.tile(FACE[:1], (1, 600, 1)), names, 120.0))
    assert "no such file" in refusal(tmp_path / "take.c3d")
