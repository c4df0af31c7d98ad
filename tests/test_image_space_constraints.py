"""Correspondences from a user's file: round trip by hand, frames, which scans they touch, and every refusal."""

import json

import numpy as np
import pytest

from mien.errors import BadInput
from mien.image_space.constraints import PairConstraint, place_constraints, read_constraints, touched
from mien.transforms import Transform, rotation_from_vector

PAIR = {
    "scans": ["smile.ply", "frown"],
    "points": [[[1, 2, 3], [4, 5, 6]], [[7, 8, 9], [10, 11, 12]]],
    "curves": [[[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 0], [2, 1, 0]]]],
}


def written(tmp_path, content):
    path = tmp_path / "constraints.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def test_a_file_is_read_as_it_says(tmp_path):
    (pair,) = read_constraints(written(tmp_path, {"pairs": [PAIR]}))
    assert pair.scans == ("smile.ply", "frown")
    np.testing.assert_array_equal(pair.points[0], [[1, 2, 3], [7, 8, 9]])
    np.testing.assert_array_equal(pair.points[1], [[4, 5, 6], [10, 11, 12]])
    assert [len(line) for line in pair.curves[0]] == [2, 3]


def test_points_or_curves_may_be_missing(tmp_path):
    scans = PAIR["scans"]
    pairs = [{"scans": scans, "points": PAIR["points"]}, {"scans": scans, "curves": PAIR["curves"]}]
    with_points, with_curves = read_constraints(written(tmp_path, {"pairs": pairs}))
    assert (with_points.points.shape, with_points.curves) == ((2, 2, 3), ())
    assert (with_curves.points.shape, len(with_curves.curves)) == ((2, 0, 3), 1)


def test_each_scan_has_its_own_frame_and_unit(tmp_path):
    named = read_constraints(written(tmp_path, {"pairs": [PAIR]}))
    T = Transform(rotation_from_vector(np.array([0.1, 0.2, 0.3])), np.array([5.0, 6.0, 7.0]), 10.0)
    (placed,) = place_constraints(named, ["frown.obj", "rest.obj", "smile.ply"], [T, T, Transform.identity()])
    assert placed.scans == (2, 0)
    np.testing.assert_allclose(placed.points[0], named[0].points[0])
    np.testing.assert_allclose(placed.points[1], T.apply(named[0].points[1]))
    np.testing.assert_allclose(placed.curves[0][1], T.apply(named[0].curves[0][1]))
    with pytest.raises(BadInput, match=r"no scan is called smile\.ply; there are frown, rest"):
        place_constraints(named, ["frown.obj", "rest.obj"], [T, T])


def test_scans_touched_are_those_named_and_those_beside_them():
    near = np.array([[[1, 2]], [[0, 2]], [[4, 3]], [[2, 4]], [[3, 2]]])
    nothing = np.zeros((2, 0, 3))
    assert touched([PairConstraint((0, 1), nothing)], near) == [0, 1]
    assert touched([PairConstraint((2, 1), nothing)], near) == [0, 1, 2, 3, 4]
    assert touched([], near) == []


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "not a JSON file"),
        ([1], r'expected \{"pairs"'),
        ({"pairs": 3}, "must be a list"),
        ({"pairs": [{"scans": ["a", "b"]}]}, "pair 1: expected"),
        ({"pairs": [{**PAIR, "scans": ["a"]}]}, "two names of files"),
        ({"pairs": [{**PAIR, "scans": ["a.ply", "a"]}]}, "two different ones"),
        ({"pairs": [{**PAIR, "points": [[[1, 2, 3]]]}]}, "point 1: expected 2 places"),
        ({"pairs": [PAIR, {**PAIR, "points": [[[1, 2], [3, 4]]]}]}, "pair 2: point 1: expected places"),
        ({"pairs": [{**PAIR, "points": [[[1, 2, float("nan")], [3, 4, 5]]]}]}, "expected places"),
        ({"pairs": [{**PAIR, "curves": [[[[0, 0, 0], [1, 0, 0]]]]}]}, "curve 1 must be two lines"),
        ({"pairs": [{**PAIR, "curves": [[[[0, 0, 0]], [[0, 0, 0], [1, 0, 0]]]]}]}, "two different places"),
    ],
)
def test_what_cannot_be_read_is_named(tmp_path, content, message):
    with pytest.raises(BadInput, match=message):
        read_constraints(written(tmp_path, content))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BadInput, match="no such file"):
        read_constraints(tmp_path / "none.json")
