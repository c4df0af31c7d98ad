"""Headers: which columns are a marker, in which unit."""

import numpy as np
import pytest

from marker_files import NAMES, refusal, take, wide_csv
from mien.io.markers import read_marker_file, read_markers
from mien.io.markers.tables.table_header import marker_columns, read_preamble


def test_a_header_that_names_its_unit(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions / 10, lambda n, a: f"{n}_{a} (cm)")
    read = read_marker_file(path)
    assert (read.unit_mm, read.unit_source) == (10.0, "file")
    path = wide_csv(tmp_path / "take.csv", take().positions, lambda n, a: f"{n}_{a} (m)")
    assert "--units mm" in refusal(path)


@pytest.mark.parametrize(
    "header",
    [
        lambda n, a: f"{n}{a.upper()}",
        lambda n, a: f"{a.upper()}:{n}",
        lambda n, a: f"{n} - {a} (mm)",
        lambda n, a: f"{n}_T{a}",
        lambda n, a: f"{n}.pos{a.upper()}",
        lambda n, a: f"{n}_position_{a}",
        lambda n, a: f"{n}({a.upper()})",
        lambda n, a: f"{n}[{a}]",
        lambda n, a: f"{n}_{a}_mm",
    ],
)
def test_more_spellings(tmp_path, header):
    assert read_markers(wide_csv(tmp_path / "take.csv", take().positions, header)).labels == NAMES


def test_a_row_of_units_and_a_preamble(tmp_path):
    lines = wide_csv(tmp_path / "take.csv", take().positions / 10).read_text().splitlines()
    (tmp_path / "take.csv").write_text("\n".join([lines[0], ",".join(["cm"] * 24), *lines[1:]]))
    assert read_marker_file(tmp_path / "take.csv").unit_mm == 10
    (tmp_path / "take.csv").write_text("\n".join(["# Units: cm", "# fps = 90", *lines]))
    read = read_marker_file(tmp_path / "take.csv")
    assert (read.unit_mm, read.unit_source, read.markers.rate) == (10, "file", 90)


def test_between_blanks_a_gap_must_be_written(tmp_path):
    """A cell left empty would move all behind it to the next marker."""
    whole = wide_csv(tmp_path / "take.csv", take().positions, sep=" ").read_text()
    np.testing.assert_allclose(read_markers(tmp_path / "take.csv").positions, take().positions, atol=1e-5)
    (tmp_path / "take.csv").write_text(whole.replace(" NA", " "))
    assert "row 3 has 21 cells for 24 columns" in refusal(tmp_path / "take.csv")


def test_names_that_blanks_part_stand_over_their_axes(tmp_path):
    lines = wide_csv(tmp_path / "take.csv", take().positions, sep=" ").read_text().splitlines()[1:]
    head = ["Frame " + " ".join(NAMES), "Frame " + " ".join("XYZ" * len(NAMES))]
    (tmp_path / "take.csv").write_text("\n".join(head + [f"{i + 1} {line}" for i, line in enumerate(lines)]))
    read = read_markers(tmp_path / "take.csv", rate=60)
    assert read.labels == NAMES
    np.testing.assert_allclose(read.positions, take().positions, atol=1e-5)


def test_marker_columns():
    assert marker_columns(["A_x", "A_y", "A_z", "B_x", "B_y"]) == [("A", (0, 1, 2))]
    assert marker_columns(["A_x", "A_y", "A_z", "A_x", "A_y", "A_z"]) == [("A", (0, 1, 2)), ("A", (3, 4, 5))]
    assert marker_columns(["noseX", "noseY", "noseZ"]) == [("nose", (0, 1, 2))]
    assert marker_columns(["x", "y", "z"]) == []


def test_read_preamble():
    rows = [["Take", "smile", "Rate"], ["Frame rate: 60"], ["120"]]
    assert read_preamble(rows) == {"take": "smile", "frame rate": "60", "rate": "120"}
