import json

import numpy as np
import pytest

from mien.errors import BadInput
from mien.image_space.constraints import read_constraints
from mien.viewer.kept.clicked_pairs import FILE, ClickedPairs, ViewedScan

PAIR = {"scans": ["a.ply", "b.ply"], "points": [[[10.0, 0, 0], [20.0, 0, 0]]], "curves": []}


@pytest.fixture
def scans(tmp_path):
    return ClickedPairs([ViewedScan(tmp_path / "a.ply", 10.0), ViewedScan(tmp_path / "b.ply", 1.0)])


def save(scans, pair):
    return scans.save(json.dumps(pair).encode(), {})


def test_places_are_kept_in_the_files_units(scans, tmp_path):
    assert b"--constraints" in save(scans, PAIR).body
    kept = read_constraints(tmp_path / FILE)[0]
    np.testing.assert_allclose(kept.points, [[[1, 0, 0]], [[20, 0, 0]]])
    assert json.loads(scans.read({}).body) == {"pairs": [PAIR]}


def test_pairs_of_other_scans_stay(scans, tmp_path):
    other = {"scans": ["c.ply", "d.ply"], "points": [[[1, 2, 3], [4, 5, 6]]]}
    (tmp_path / FILE).write_text(json.dumps({"pairs": [other]}))
    save(scans, PAIR)
    save(scans, PAIR | {"curves": [[[[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0], [2, 0, 0]]]]})
    kept = read_constraints(tmp_path / FILE)
    assert [pair.scans for pair in kept] == [("c.ply", "d.ply"), ("a.ply", "b.ply")]
    assert len(kept[1].curves[0][1]) == 3
    save(scans, PAIR | {"points": []})
    assert len(read_constraints(tmp_path / FILE)) == 1


def test_what_is_no_pair_of_the_page_is_refused_and_leaves_the_file(scans, tmp_path):
    save(scans, PAIR)
    with pytest.raises(BadInput, match=r"expected two of a\.ply, b\.ply"):
        save(scans, PAIR | {"scans": ["a.ply", "z.ply"]})
    with pytest.raises(BadInput, match="two different places"):
        save(scans, PAIR | {"curves": [[[[0, 0, 0], [0, 0, 0]], [[0, 0, 0], [1, 0, 0]]]]})
    assert len(read_constraints(tmp_path / FILE)) == 1
