"""Columns and units of Live Link tables, by whatever program."""

from pathlib import Path

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.live_link_table import NAMES, SHAPES, find_columns, in_radians, in_unit, numbers, read_table

PATH = Path("a.csv")


def test_columns_in_any_order_and_spelling():
    columns = find_columns(PATH, ["headYaw", "jaw_open", "Timecode", "mouthSmile_L", "BlendShapeCount"])
    assert columns.names == ("jawOpen", "mouthSmileLeft")
    assert (columns.time, columns.shapes, columns.angles) == (2, [1, 3], [0])
    np.testing.assert_array_equal(columns.share, np.eye(2))
    assert columns.turn.shape == (1, 9)
    assert "2 shape names matched loosely" in columns.notes[0]
    assert columns.notes[1].startswith("2 of 52 shapes are there; missing: ")


def test_the_app_s_own_header_needs_no_word():
    columns = find_columns(PATH, ["Timecode", "BlendShapeCount", *SHAPES])
    assert (columns.names, columns.notes) == (NAMES, ())


@pytest.mark.parametrize("header", [["a", "b"], ["jawOpen", "mouthPucker"]])
def test_what_is_no_performance_is_refused(header):
    with pytest.raises(BadInput, match="is no Live Link Face CSV"):
        find_columns(PATH, header)


@pytest.mark.parametrize(("values", "factor", "told"), [([0.0, 1.2], 1.0, []), ([0.0, 55.0], 0.01, ["percent"])])
def test_weights_and_percent(values, factor, told):
    found, notes = in_unit(PATH, np.array([values]))
    np.testing.assert_allclose(found, factor * np.array([values]))
    assert [word in note for word, note in zip(told, notes, strict=True)] == [True] * len(told)


def test_what_is_neither_is_refused():
    with pytest.raises(BadInput, match=r"neither 0\.\.1 nor percent"):
        in_unit(PATH, np.array([[0.0, 500.0]]))


def test_degrees_are_known_by_their_size_and_by_their_eyes():
    angles, weights, names = np.zeros((2, 9)), np.zeros((2, 1)), ("eyeLookOutLeft",)
    angles[:, 0] = 30.0
    turned, notes = in_radians(PATH, angles, names, weights)
    np.testing.assert_allclose(turned[:, 0], np.radians(30))
    assert "read as degrees" in notes[0]
    small = np.zeros((2, 9))
    small[:, 3] = 1.0
    assert in_radians(PATH, small, names, weights)[1] == []
    small[:, 3] *= 17.5
    assert in_radians(PATH, small, names, weights + 0.5)[1] != []
    with pytest.raises(BadInput, match="neither radians nor degrees"):
        in_radians(PATH, 100 * angles, names, weights)


def test_cells(tmp_path):
    (tmp_path / "a.csv").write_text("Timecode;JawOpen\n00:00:00:00;0,5\n00:00:00:01;\n")
    header, rows = read_table(tmp_path / "a.csv")
    assert header == ["Timecode", "JawOpen"]
    np.testing.assert_array_equal(numbers(PATH, rows, [1]), [[0.5], [np.nan]])
    with pytest.raises(BadInput, match="no number"):
        numbers(PATH, [["x", "y"]], [1])


@pytest.mark.parametrize("ahead", ["Recording,my take", "# app 1.3\n\n", "sep=;"])
def test_a_title_ahead_of_the_header_is_passed_over(tmp_path, ahead):
    rows = [";".join(("Timecode", "BlendShapeCount", *SHAPES)), ";".join(("1:02", "52", *["0,5"] * 51, "N/A"))]
    (tmp_path / "a.csv").write_text("\n".join([ahead, *rows]))
    header, body = read_table(tmp_path / "a.csv")
    assert header[2:] == list(SHAPES)
    found = numbers(tmp_path / "a.csv", body, list(range(2, 54)))
    np.testing.assert_array_equal(found, [[0.5] * 51 + [np.nan]])
