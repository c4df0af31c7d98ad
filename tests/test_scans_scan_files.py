"""Scans of a folder and their frames: what matches, what is left out and why."""

import json

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.meshes import write_mesh
from mien.scans.scan_files import match_scans, read_scans
from small_scans import sheet


def touch(folder, *names):
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).touch()
    return folder


def test_scans_find_their_frames(tmp_path):
    folder = touch(tmp_path / "scans", "frame_000123.ply", "take2_7.obj", "notes.txt")
    found, out = match_scans(folder, (7, 123))
    assert [(f.name, f.frame) for f in found] == [("take2_7", 7), ("frame_000123", 123)]
    assert out == ()
    (folder / "scans.json").write_text('{"take2_7.obj": 5, "frame_000123.ply": 9}')
    assert [f.frame for f in match_scans(folder, (9, 5))[0]] == [9, 5]


@pytest.mark.parametrize(
    ("names", "who", "why"),
    [
        (("smile.ply",), "smile.ply", "ends in no frame number"),
        (("b_3.ply",), "b_3.ply", "frame 3 is not among the selected ones"),
        (("b_1.ply",), "b_1.ply", "frame 1 has a scan already, a_1.ply"),
        ((), "selected frame 40", "it has no scan"),
    ],
)
def test_what_matches_no_frame_is_left_out_and_told(tmp_path, names, who, why):
    folder = touch(tmp_path / "scans", "a_1.ply", "a_2.ply", *names)
    frames = (1, 2) if names else (1, 2, 40)
    found, out = match_scans(folder, frames)
    assert [f.path.name for f in found] == ["a_1.ply", "a_2.ply"]
    assert [o.name for o in out] == [who]
    assert why in out[0].why
    with pytest.raises(BadInput, match=why):
        match_scans(folder, frames, strict=True)


def test_entries_of_the_listing_are_judged_one_by_one(tmp_path):
    folder = touch(tmp_path / "scans", "a.ply", "b.ply", "c.ply", "a.obj")
    listing = {"a.ply": 1, "b.ply": 2, "c.ply": "three", "gone.ply": 4, "a.obj": 5}
    (folder / "scans.json").write_text(json.dumps(listing))
    found, out = match_scans(folder, (1, 2, 5))
    assert [f.name for f in found] == ["a", "b"]
    assert {o.name for o in out} == {"c.ply", "gone.ply", "a.obj", "selected frame 5"}
    (folder / "scans.json").write_text("not json")
    with pytest.raises(BadInput, match="a frame for each scan"):
        match_scans(folder, (1, 2))


def test_two_scans_are_needed(tmp_path):
    with pytest.raises(BadInput, match="no scans in it"):
        match_scans(touch(tmp_path / "none"), (1, 2))
    with pytest.raises(BadInput, match=r"1 scan of selected frames can be used, and it takes 2; left out: b_9.ply"):
        match_scans(touch(tmp_path / "one", "a_1.ply", "b_9.ply"), (1, 2))


def test_a_scan_that_cannot_be_read_does_not_stop_the_others(tmp_path):
    folder = touch(tmp_path / "scans", "a_3.ply")
    for name in ("a_1.ply", "a_2.ply"):
        write_mesh(folder / name, sheet())
    (folder / "a_3.ply").write_bytes(b"ply broken")
    files, _ = match_scans(folder, (1, 2, 3))
    readable, scans, out = read_scans(files, None)
    assert [scan.name for scan in scans] == [f.name for f in readable] == ["a_1", "a_2"]
    np.testing.assert_allclose(scans[0].mesh.vertices, sheet().vertices, atol=1e-4)
    assert out[0].name == "a_3.ply"
    with pytest.raises(BadInput, match=r"a_3\.ply"):
        read_scans(files, None, strict=True)
