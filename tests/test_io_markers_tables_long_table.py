"""Tables with a row for every marker and frame."""

import numpy as np
import pytest

from marker_files import FACE, NAMES, refusal, take
from mien.io.markers import read_marker_file, read_markers


def test_long_csv_in_any_order(tmp_path):
    markers = take()
    rows = [(t, n, *markers.positions[t, i]) for t in range(5) for i, n in enumerate(NAMES) if (t, i) != (1, 2)]
    lines = ["Frame,Marker,X,Y,Z"] + [f"{t},{n},{x:.6f},{y:.6f},{z:.6f}" for t, n, x, y, z in rows[:8] + rows[:7:-1]]
    (tmp_path / "take.csv").write_text("\n".join(lines))
    back = read_markers(tmp_path / "take.csv")
    order = [back.labels.index(n) for n in NAMES]
    np.testing.assert_allclose(back.positions[:, order], markers.positions, atol=1e-5)


def test_long_csv_by_time(tmp_path):
    lines = ["time,label,x,y,z"]
    lines += [f"{t / 50},{n},{x},{y},{z}" for t in (0, 1, 3, 4, 5) for n, (x, y, z) in zip(NAMES, FACE, strict=True)]
    (tmp_path / "take.csv").write_text("\n".join(lines))
    back = read_markers(tmp_path / "take.csv")
    assert back.rate == 50
    np.testing.assert_array_equal(back.seen.all(axis=1), [True, True, False, True, True, True])


def test_a_label_twice_in_one_frame_of_a_long_table_is_refused(tmp_path):
    rows = [(t, n, *FACE[i] + t) for t in range(4) for i, n in enumerate(NAMES)]
    lines = ["frame,label,x,y,z"] + [",".join(map(str, row)) for row in rows]
    path = tmp_path / "long.csv"
    path.write_text("\n".join([*lines, "0,M1,1,2,3"]))
    assert "row 34: duplicate marker labels: M1 comes twice in frame 0" in refusal(path)
    path.write_text("\n".join(line.replace("M1", "M0") for line in lines))
    assert read_markers(path).labels == ("M0_1", "M0_2", *NAMES[2:])


def test_rows_that_repeat_others_are_left_out(tmp_path):
    lines = ["frame,label,x,y,z"]
    lines += [f"{t},{n},{x},{y},{z}" for t in range(4) for n, (x, y, z) in zip(NAMES, FACE, strict=True)]
    (tmp_path / "take.csv").write_text("\n".join([*lines, *lines[5:8]]))
    read = read_marker_file(tmp_path / "take.csv")
    np.testing.assert_allclose(read.markers.positions, np.tile(FACE, (4, 1, 1)))
    assert "3 rows repeat others" in read.warnings[0]


def test_a_time_code_is_no_key(tmp_path):
    lines = ["time,label,x,y,z"] + [f"00:00:00:0{t},M{i},1,2,{i}" for t in range(3) for i in range(7)]
    (tmp_path / "take.csv").write_text("\n".join(lines))
    assert "column time holds no numbers" in refusal(tmp_path / "take.csv")


@pytest.mark.parametrize(
    "head", ["Frame,MarkerName,pos_x,pos_y,pos_z", "frame,id,tx,ty,tz", "frame,label,X_mm,Y_mm,Z_mm"]
)
def test_columns_by_other_names(tmp_path, head):
    rows = [f"{t},{name},{x},{y},{z}" for t in range(3) for name, (x, y, z) in zip(NAMES, FACE, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows]))
    read = read_marker_file(tmp_path / "a.csv")
    assert read.markers.labels == NAMES
    np.testing.assert_allclose(read.markers.positions, np.tile(FACE, (3, 1, 1)))
    assert (read.unit_source == "file") == ("mm" in head)
