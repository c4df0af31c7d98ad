"""CSV of Motive: markers by the row of types, nothing else."""

import numpy as np
import pytest

from marker_files import NAMES, cells, take
from mien.io.markers import read_marker_file


def test_two_row_header_of_optitrack(tmp_path):
    each = [n for n in NAMES for _ in "xyz"]
    lines = [
        "Format Version,1.23,Take Name,smile,Export Frame Rate,240.0,Length Units,Meters",
        ",".join(["", "Type"] + ["Marker"] * 24),
        ",".join(["", "Name"] + [f"Jane:{n}" for n in each]),
        ",".join(["", "ID"] + [f"4F:{i // 3}" for i in range(24)]),
        ",".join(["", ""] + ["Position"] * 24),
        ",".join(["Frame", "Time (Seconds)"] + list("XYZ") * 8),
    ]
    for t, frame in enumerate(take().positions.reshape(5, -1) / 1000):
        lines.append(",".join([str(t), f"{t / 240:.6f}", *("" if np.isnan(v) else f"{v:.9f}" for v in frame)]))
    (tmp_path / "take.csv").write_text("\n".join(lines))
    read = read_marker_file(tmp_path / "take.csv")
    assert (read.unit_mm, read.unit_source, read.markers.labels) == (1000.0, "file", NAMES)
    np.testing.assert_allclose(read.markers.rate, 240, rtol=1e-3)
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=1e-5)


HEAD = ("Head:Marker 001", "Head:Marker 002", "Head:Marker 003")


def export(path, rotation="XYZW", unit="Millimeters", scale=1.0, with_head=True, rates="Export Frame Rate,60.0"):
    """A take with a rigid body: its rotation, position, error, its markers with their quality, and labelled markers."""
    positions = take().positions
    head = np.tile(np.array([[0.0, 90, -20], [40, 90, -30], [-40, 90, -30]]), (5, 1, 1))
    labelled = np.concatenate([head, positions], axis=1) if with_head else positions
    names = (*(HEAD if with_head else ()), *(f"Face:{name}" for name in NAMES))
    columns = [("Rigid Body", "Head", "Rotation", axis) for axis in rotation]
    columns += [("Rigid Body", "Head", "Position", axis) for axis in "XYZ"]
    columns += [("Rigid Body", "Head", "Mean Marker Error", "")]
    for name in HEAD:
        columns += [("Rigid Body Marker", name, "Position", axis) for axis in "XYZ"]
        columns += [("Rigid Body Marker", name, "Marker Quality", "")]
    columns += [("Bone", "Skeleton:Hip", "Rotation", axis) for axis in rotation]
    columns += [("Bone", "Skeleton:Hip", "Position", axis) for axis in "XYZ"]
    columns += [("Marker", name, "Position", axis) for name in names for axis in "XYZ"]
    rows = []
    for t, marker_cells in enumerate(cells(labelled * scale)):
        solved = cells(head[t : t + 1] * scale)[0]
        body = [cell for k in range(3) for cell in (*solved[3 * k : 3 * k + 3], "1")]
        bone = ["0"] * (len(rotation) + 3)
        rows.append([str(t), f"{t / 60:.6f}", *["0"] * (len(rotation) + 4), *body, *bone, *marker_cells])
    types, labels, kinds, axes = zip(*columns, strict=True)
    lines = [f"Format Version,1.24,Take Name,smile,{rates},Rotation Type,Quaternion,Length Units,{unit}", ""]
    lines += [",".join(["", key, *row]) for key, row in (("Type", types), ("Name", labels), ("ID", labels))]
    lines += [",".join(["", "Parent", *[""] * len(types)]), ",".join(["", "", *kinds])]
    lines += [",".join(["Frame", "Time (Seconds)", *axes]), *(",".join(row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("rotation", ["XYZW", "XYZ"])
@pytest.mark.parametrize(("unit", "scale"), [("Millimeters", 1.0), ("Centimeters", 0.1), ("Meters", 1e-3)])
def test_markers_alone(tmp_path, rotation, unit, scale):
    read = read_marker_file(export(tmp_path / "take.csv", rotation, unit, scale))
    assert read.markers.labels == ("Marker 001", "Marker 002", "Marker 003", *NAMES)
    np.testing.assert_allclose(read.markers.positions[:, 3:], take().positions, atol=1e-3)
    assert (read.markers.rate, read.markers.notes, read.unit_source) == (60, None, "file")
    assert "3 markers of rigid bodies or bones repeat others" in read.warnings[0]


def test_a_body_whose_markers_stand_nowhere_else_is_read(tmp_path):
    read = read_marker_file(export(tmp_path / "take.csv", with_head=False))
    assert read.markers.labels == (*NAMES, "Marker 001", "Marker 002", "Marker 003")
    assert read.warnings == ()


def test_the_rate_of_the_export_counts(tmp_path):
    rates = "Capture Frame Rate,240.0,Export Frame Rate,60.0"
    assert read_marker_file(export(tmp_path / "take.csv", rates=rates)).markers.rate == 60


def test_unlabelled_trajectories_are_left_out(tmp_path):
    path = export(tmp_path / "take.csv")
    path.write_text(path.read_text().replace("Face:M0", "Unlabeled 1023"))
    read = read_marker_file(path)
    assert read.markers.labels[3:] == NAMES[1:]
    assert any("1 of 11 points are not labelled" in line for line in read.warnings)


def test_columns_that_end_with_a_delimiter_and_semicolons(tmp_path):
    path = export(tmp_path / "take.csv")
    path.write_text("\n".join(line.replace(",", ";") + ";" for line in path.read_text().splitlines()))
    np.testing.assert_allclose(read_marker_file(path).markers.positions[:, 3:], take().positions, atol=1e-3)


def test_without_the_row_of_types_a_body_is_told_by_its_rotation(tmp_path):
    lines = export(tmp_path / "a.csv").read_text().splitlines()
    (tmp_path / "a.csv").write_text("\n".join(line for line in lines if ",Type," not in line))
    assert "Head" not in read_marker_file(tmp_path / "a.csv").markers.labels
