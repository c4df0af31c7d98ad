"""TRC takes."""

import numpy as np
import pytest

from marker_files import NAMES, refusal, take, trc
from mien.io.markers import read_marker_file


@pytest.mark.parametrize(("units", "mm"), [("mm", 1), ("m", 1000)])
def test_trc(tmp_path, units, mm):
    read = read_marker_file(trc(tmp_path / "take.trc", take().positions / mm, units))
    assert (read.markers.labels, read.markers.rate, read.unit_source, read.warnings) == (NAMES, 100, "file", ())
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=2e-3)


def test_a_trc_that_is_none(tmp_path):
    (tmp_path / "take.trc").write_text("hello\n" * 9)
    assert "not a TRC file" in refusal(tmp_path / "take.trc")
    text = trc(tmp_path / "take.trc", take().positions).read_text()
    (tmp_path / "take.trc").write_text("\n".join(text.splitlines()[:5]))
    assert "no marker points" in refusal(tmp_path / "take.trc")


def test_dialects(tmp_path):
    """A byte-order mark, CRLF, a first line of another program, no blank line, trailing tabs, one name for three."""
    lines = trc(tmp_path / "take.trc", take().positions).read_text().splitlines()
    once = "Frame#\tTime\t" + "\t".join(NAMES)
    for changed in (
        ["made by hand", *lines],
        [line for line in lines if line],
        [line + "\t\t" for line in lines],
        [once if line.startswith("Frame#") else line for line in lines],
        ["", *lines],
    ):
        (tmp_path / "take.trc").write_bytes("\r\n".join(changed).encode("utf-8-sig"))
        read = read_marker_file(tmp_path / "take.trc")
        assert (read.markers.labels, read.markers.rate, read.unit_source) == (NAMES, 100, "file")
        np.testing.assert_allclose(read.markers.positions, take().positions, atol=2e-3)


def test_a_marker_without_a_name(tmp_path):
    text = trc(tmp_path / "take.trc", take().positions).read_text()
    (tmp_path / "take.trc").write_text(text.replace("\tM3\t", "\t\t"))
    read = read_marker_file(tmp_path / "take.trc")
    assert read.markers.labels == (*NAMES[:3], *NAMES[4:])
    np.testing.assert_allclose(read.markers.positions[:, 3:], take().positions[:, 4:], atol=2e-3)


def test_between_blanks_a_gap_must_be_written(tmp_path):
    """A cell left empty would move all behind it to the next marker."""
    text = trc(tmp_path / "take.trc", take().positions).read_text().replace("\t", " ")
    (tmp_path / "take.trc").write_text(text)
    assert "row 8 has 23 cells for 26 columns" in refusal(tmp_path / "take.trc")
    gap = np.isnan(take().positions)
    lines = trc(tmp_path / "take.trc", np.where(gap, -9999.0, take().positions)).read_text().replace("\t", " ")
    (tmp_path / "take.trc").write_text(lines)
    np.testing.assert_array_equal(np.isnan(read_marker_file(tmp_path / "take.trc").markers.positions), gap)
