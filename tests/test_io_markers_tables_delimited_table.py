"""Text tables as cells: encodings, delimiters, numbers."""

import numpy as np
import pytest

from marker_files import NAMES, cells, refusal, take, wide_csv
from mien.io.markers import read_marker_file, read_markers
from mien.io.markers.tables.delimited_table import (
    DelimitedTable,
    cells_to_numbers,
    commonest_delimiter,
    positive_number,
    sniff_delimiter,
)


def test_tables_that_are_none(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("")
    assert "is empty" in refusal(path)
    path.write_text("a,b,c,d\n1,2,3,4\n")
    assert "no marker columns" in refusal(path)
    path.write_bytes(b"\x00\x01\x02" * 50)
    assert "binary" in refusal(path)
    wide_csv(path, take().positions)
    path.write_text(path.read_text().replace("NA", "oops", 1))
    assert "row 3: 'oops' is neither a number nor NA" in refusal(path)
    wide_csv(path, take().positions, extra=[("Frame", [1, 2, 2, 3, 4])])
    assert "frame numbers must increase, but 2 is followed by 2" in refusal(path)
    wide_csv(path, take().positions, extra=[("Frame", [1, 2, 10**9, 10**9 + 1, 10**9 + 2])])
    assert "renumber or split" in refusal(path)
    path.write_text(wide_csv(path, take().positions).read_text().splitlines()[0])
    assert "no marker points" in refusal(path)
    path.write_text("label,x,y,z\nM0,1,2,3\n")
    assert "frame or time column" in refusal(path)
    path.write_text("frame,label,x,y,z\n1,M0,1,2,3\n,M1,1,2,3\n")
    assert "row 3 has no frame" in refusal(path)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
def test_encodings(tmp_path, encoding):
    names = ["Stirn_ü", *NAMES[1:]]
    text = wide_csv(
        tmp_path / "take.csv", take().positions, lambda n, a: f"{n.replace('M0', 'Stirn_ü')}_{a}"
    ).read_text()
    (tmp_path / "take.csv").write_bytes(text.encode(encoding))
    assert read_markers(tmp_path / "take.csv").labels == tuple(names)


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r", "\n\n"])
@pytest.mark.parametrize("trail", ["", ",", ",,"])
def test_line_ends_blank_lines_and_trailing_delimiters(tmp_path, ends, trail):
    lines = wide_csv(tmp_path / "take.csv", take().positions).read_text().splitlines()
    (tmp_path / "take.csv").write_bytes(ends.join(line + trail for line in lines).encode())
    read = read_marker_file(tmp_path / "take.csv")
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=1e-5)
    assert read.markers.notes is None


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_quoted_headers_and_decimal_commas(tmp_path, delimiter):
    head = [f'"{name}_{axis}"' for name in NAMES for axis in "xyz"]
    body = [[f'"{cell.replace(".", ",")}"' if cell else "" for cell in row] for row in cells(take().positions)]
    text = "\n".join(delimiter.join(row) for row in [head, *body])
    (tmp_path / "take.csv").write_text(text)
    np.testing.assert_allclose(read_markers(tmp_path / "take.csv").positions, take().positions, atol=1e-5)


@pytest.mark.parametrize("gap", ["", "NaN", "N/A", "#N/A", "null", "-", "-nan(ind)", "0.000000"])
def test_every_spelling_of_a_gap(tmp_path, gap):
    text = wide_csv(tmp_path / "take.csv", take().positions).read_text()
    (tmp_path / "take.csv").write_text(text.replace("NA", gap))
    np.testing.assert_array_equal(read_markers(tmp_path / "take.csv").seen, take().seen)


def test_cells_to_numbers(tmp_path):
    got = cells_to_numbers(tmp_path, [["1.5", "1,5", "1,234.5", "1.234,5", "", "-2e3"]], [1])
    np.testing.assert_array_equal(got, [[1.5, 1.5, 1234.5, 1234.5, np.nan, -2000]])
    assert [positive_number(text) for text in ("60", "59,94", "-1", "", "fast")] == [60, 59.94, None, None, None]


def test_the_row_of_a_bad_cell_is_that_of_the_file(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions)
    path.write_text("\n\n" + path.read_text().replace("NA", "oops", 1))
    assert "row 5: 'oops'" in refusal(path)


def test_sniff_delimiter():
    assert [sniff_delimiter(text) for text in ("a,b,c,d", "a;b;1,5;2,5;3", "a\tb\tc\td,e", "a b c d")] == [
        ",",
        ";",
        "\t",
        " ",
    ]


def test_the_commonest_delimiter_of_a_small_table():
    assert commonest_delimiter("time,brow") == ","
    assert commonest_delimiter("time\tbrow, left\tlid") == "\t"
    assert commonest_delimiter("0;1,5") == ";"  # as often as the decimal comma
    assert commonest_delimiter("") == ";"


def test_seconds(tmp_path):
    table = DelimitedTable(tmp_path, ["a", "b", "c"], ["ms", "", ""], [["20", "0:01:02.5", "00:00:01:05"]], [1])
    np.testing.assert_allclose(table.seconds(0), [0.02])
    np.testing.assert_allclose(table.seconds(1), [62.5])
    assert table.seconds(2) is None


def test_a_quote_that_never_closes(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions)
    path.write_text('"' + path.read_text() + "x" * 200_000)
    assert "never closed" in refusal(path)
