"""Marker takes: each format by hand, round trips, and every refusal with its line."""

from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.io.markers import read_marker_file, read_markers, write_c3d

REAL = Path(__file__).resolve().parents[2] / "shared/data/markers16"

# Eight points of a face's size (box diagonal 170 mm), none at zero.
FACE = np.array(
    [
        [60.0, 50, 10], [-60, 50, 10], [30, 55, 30], [-30, 55, 30],
        [1, 0, 60], [35, -50, 40], [-35, -50, 40], [1, -60, 50],
    ]
)  # fmt: skip
NAMES = tuple(f"M{i}" for i in range(8))


def take(frames: int = 5, rate: float = 60.0) -> Markers:
    rng = np.random.default_rng(7)
    positions = FACE + rng.normal(0, 1, (frames, 8, 3))
    positions[1, 2] = np.nan
    return Markers(positions, NAMES, rate)


def wide_csv(path: Path, positions: np.ndarray, header=lambda n, a: f"{n}_{a}", sep: str = ",", extra=()) -> Path:
    columns = [header(n, a) for n in NAMES[: positions.shape[1]] for a in "xyz"]
    rows = [sep.join([*(c for c, _ in extra), *columns])]
    for t, frame in enumerate(positions.reshape(len(positions), -1)):
        cells = ["NA" if np.isnan(v) else f"{v:.6f}" for v in frame]
        if sep == ";":
            cells = [c.replace(".", ",") for c in cells]
        rows.append(sep.join([*(str(values[t]) for _, values in extra), *cells]))
    path.write_text("\n".join(rows) + "\n")
    return path


def refusal(path: Path, **options) -> str:
    with pytest.raises(BadInput) as caught:
        read_markers(path, **options)
    line = str(caught.value)
    assert "\n" not in line
    return line


# --- C3D ---------------------------------------------------------------------------------------------------------


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


def custom_c3d(path: Path, labels: list[str], points: np.ndarray, units=("mm",), groups: dict | None = None) -> Path:
    """A C3D as a capture program might write it: points (t, k, 3)."""
    content = ezc3d.c3d()
    point = content["parameters"]["POINT"]
    point["RATE"]["value"] = [100.0]
    point["LABELS"]["value"] = labels
    point["UNITS"]["value"] = list(units)
    for name, values in (groups or {}).items():
        content.add_parameter("POINT", name, values)
    data = np.ones((4, len(labels), len(points)))
    data[:3] = points.transpose(2, 1, 0)
    content["data"]["points"] = data
    content.write(str(path))
    return path


def test_c3d_leaves_out_what_is_no_marker_and_drops_the_subject(tmp_path):
    labels = [f"Jane:{n}" for n in NAMES] + ["*11", "Jane:HeadAngles", "Jane:CoM"]
    points = np.concatenate([np.tile(FACE, (3, 1, 1)), np.full((3, 3, 3), 5000.0)], axis=1)
    path = custom_c3d(tmp_path / "take.c3d", labels, points, groups={"MODELED_MARKERS": ["Jane:CoM"]})
    read = read_marker_file(path)
    assert read.markers.labels == NAMES
    assert read.warnings == (
        f"{path}: 2 of 11 points are computed (angles, forces, ...) and were left out",
        f"{path}: 1 of 9 points are not labelled and were left out",
    )


def test_two_people_in_one_c3d_keep_their_prefixes(tmp_path):
    labels = ["A:nose", "A:chin", "A:brow", "B:nose", "B:chin", "B:brow"]
    path = custom_c3d(tmp_path / "take.c3d", labels, np.tile(FACE[:6], (3, 1, 1)))
    assert read_markers(path).labels == tuple(labels)


def test_zeros_are_gaps(tmp_path):
    points = np.tile(FACE, (3, 1, 1))
    points[1, 4] = 0
    seen = read_markers(custom_c3d(tmp_path / "take.c3d", list(NAMES), points)).seen
    assert not seen[1, 4]
    assert seen.sum() == 23


def test_more_than_255_points(tmp_path):
    """C3D keeps at most 255 names in LABELS and puts the rest in LABELS2."""
    rng = np.random.default_rng(1)
    positions = FACE[rng.integers(0, 8, 300)] + rng.normal(0, 3, (2, 300, 3))
    names = tuple(f"P{i}" for i in range(300))
    write_c3d(tmp_path / "take.c3d", Markers(positions, names, 120.0))
    back = read_markers(tmp_path / "take.c3d")
    assert back.labels == names
    np.testing.assert_allclose(back.positions, positions, rtol=1e-5, atol=1e-5)


def test_cut_off_c3d_is_refused(tmp_path):
    write_c3d(tmp_path / "take.c3d", take(frames=60))
    data = (tmp_path / "take.c3d").read_bytes()
    (tmp_path / "take.c3d").write_bytes(data[: len(data) - 2000])
    assert "cut off" in refusal(tmp_path / "take.c3d")


def test_a_c3d_cut_off_anywhere_is_refused(tmp_path):
    write_c3d(tmp_path / "take.c3d", take(), up="+Z")
    data = (tmp_path / "take.c3d").read_bytes()
    frames_end = 2 * 512 + 5 * 8 * 16
    assert not any(data[frames_end:])
    for size in (*range(500, 1600, 13), *range(1600, frames_end, 97)):
        (tmp_path / "cut.c3d").write_bytes(data[:size])
        refusal(tmp_path / "cut.c3d")


def test_a_c3d_whose_counts_disagree_is_refused(tmp_path):
    write_c3d(tmp_path / "take.c3d", take())
    data = bytearray((tmp_path / "take.c3d").read_bytes())
    data[2] = 9
    (tmp_path / "take.c3d").write_bytes(data)
    assert "9 points in its header, 8 in POINT:USED" in refusal(tmp_path / "take.c3d")


@pytest.mark.parametrize("content", [b"", b"hello, this is text\n" * 100, b"\x02\x51" + bytes(1000)])
def test_a_file_that_is_not_c3d_is_refused(tmp_path, content):
    (tmp_path / "take.c3d").write_bytes(content)
    assert "C3D" in refusal(tmp_path / "take.c3d")


def test_a_c3d_without_points_is_refused(tmp_path):
    content = ezc3d.c3d()
    content["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    content["parameters"]["ANALOG"]["RATE"]["value"] = [100.0]
    content["parameters"]["ANALOG"]["LABELS"]["value"] = ["force"]
    content["data"]["points"] = np.zeros((4, 0, 4))
    content["data"]["analogs"] = np.ones((1, 1, 4))
    content.write(str(tmp_path / "take.c3d"))
    assert "no marker points, only analog channels" in refusal(tmp_path / "take.c3d")


# --- units -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("unit", "mm"), [("mm", 1), ("cm", 10), ("m", 1000), ("in", 25.4)])
def test_each_unit_of_a_c3d(tmp_path, unit, mm):
    path = custom_c3d(tmp_path / "take.c3d", list(NAMES), np.tile(FACE, (3, 1, 1)) / mm, units=(unit,))
    np.testing.assert_allclose(read_markers(path).positions[0], FACE, rtol=1e-5)


@pytest.mark.parametrize(
    ("unit", "scale", "size", "better"), [("m", 1.0, "174 m ", "--units mm"), ("mm", 1e-3, "0.17 mm", "--units m ")]
)
def test_a_stated_unit_that_makes_no_face_names_the_right_one(tmp_path, unit, scale, size, better):
    path = custom_c3d(tmp_path / "take.c3d", list(NAMES), np.tile(FACE, (3, 1, 1)) * scale, units=(unit,))
    line = refusal(path)
    assert size in line
    assert better in line
    np.testing.assert_allclose(read_markers(path, unit=better.split()[1]).positions[0], FACE, rtol=1e-5)


@pytest.mark.parametrize(("scale", "unit"), [(1.0, 1.0), (0.1, 10.0), (1e-3, 1000.0)])
def test_an_unstated_unit_is_the_one_that_makes_a_face(tmp_path, scale, unit):
    read = read_marker_file(wide_csv(tmp_path / "take.csv", take().positions * scale))
    assert (read.unit_mm, read.unit_source) == (unit, "assumed")
    assert "no unit named" in read.warnings[0]


def test_an_unheard_of_unit_is_guessed_from_the_size(tmp_path):
    read = read_marker_file(wide_csv(tmp_path / "take.csv", take().positions / 184.84))
    assert read.unit_source == "guessed"
    span = np.nanmedian(np.linalg.norm(np.ptp(read.markers.positions, axis=1), axis=1))
    np.testing.assert_allclose(span, 140, rtol=1e-3)
    assert "guess" in read.warnings[0]


def test_a_number_is_a_unit(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions / 184.84)
    np.testing.assert_allclose(read_markers(path, unit="184.84").positions, take().positions, atol=1e-3)
    assert "neither" not in refusal(path, unit="furlong")
    assert "expected mm, cm, m, in" in refusal(path, unit="furlong")
    assert "would make it a face" in refusal(path, unit="mm")


# --- tables ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sep", [",", ";", "\t"])
@pytest.mark.parametrize(
    "header",
    [
        lambda n, a: f"{n}_{a}",
        lambda n, a: f"{n}.{a.upper()}",
        lambda n, a: f"Jane:{n}:{a.upper()}",
        lambda n, a: f"{a}_{n}",
        lambda n, a: f"{n} {a} [mm]",
    ],
)
def test_wide_csv(tmp_path, sep, header):
    markers = take()
    back = read_markers(wide_csv(tmp_path / "take.csv", markers.positions, header, sep))
    assert back.labels == NAMES
    np.testing.assert_allclose(back.positions, markers.positions, atol=1e-5)


def test_a_header_that_names_its_unit(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions / 10, lambda n, a: f"{n}_{a} (cm)")
    read = read_marker_file(path)
    assert (read.unit_mm, read.unit_source) == (10.0, "file")
    path = wide_csv(tmp_path / "take.csv", take().positions, lambda n, a: f"{n}_{a} (m)")
    assert "--units mm" in refusal(path)


def test_time_gives_the_rate_and_other_columns_become_notes(tmp_path):
    extra = [("Time", [f"{t / 120:.4f}" for t in range(5)]), ("Stimulus", list("aabbb")), ("level", range(5))]
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=extra))
    assert back.rate == 120
    assert back.notes is not None
    assert list(back.notes["Stimulus"]) == list("aabbb")
    np.testing.assert_array_equal(back.notes["level"], range(5))
    assert set(back.notes) == {"Stimulus", "level"}
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=[("time_ms", range(0, 50, 10))]))
    assert (back.rate, back.notes) == (100, None)


def test_the_rate_by_argument_and_by_default(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions)
    assert read_markers(path).rate == 30
    assert "30 frames/s assumed" in read_marker_file(path).warnings[-1]
    assert read_markers(path, rate=240.0).rate == 240
    assert "cannot be" in refusal(path, rate=-1.0)


def test_frame_numbers_left_out_become_gaps(tmp_path):
    extra = [("Frame", [7, 8, 10, 11, 12]), ("mood", list("abcde"))]
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=extra))
    assert back.positions.shape[0] == 6
    assert not back.seen[2].any()
    np.testing.assert_allclose(back.positions[3], take().positions[2], atol=1e-5)
    assert back.notes is not None
    assert list(back.notes["mood"]) == ["a", "b", "", "c", "d", "e"]


def test_every_second_frame_is_a_take_without_gaps(tmp_path):
    extra = [("Frame", [2, 4, 6, 8, 10]), ("Time", [t / 60 for t in range(5)])]
    back = read_markers(wide_csv(tmp_path / "take.csv", take().positions, extra=extra))
    assert back.positions.shape[0] == 5
    assert back.rate == 60


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


def test_two_row_header_of_vicon(tmp_path):
    names = ["", ""] + [cell for n in NAMES for cell in (f"Jane:{n}", "", "")]
    units = ["", ""] + ["mm"] * 24
    axes = ["Frame", "Sub Frame"] + list("XYZ") * 8
    lines = ["Trajectories", "120", ",".join(names), ",".join(axes), ",".join(units)]
    for t, frame in enumerate(take().positions.reshape(5, -1)):
        lines.append(",".join([str(t + 1), "0", *("" if np.isnan(v) else f"{v:.6f}" for v in frame)]))
    (tmp_path / "take.csv").write_text("\n".join(lines))
    read = read_marker_file(tmp_path / "take.csv")
    assert (read.markers.rate, read.markers.labels, read.unit_source) == (120, NAMES, "file")
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=1e-5)


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


def trc(path: Path, positions: np.ndarray, units: str = "mm") -> Path:
    names = "\t\t\t".join(NAMES)
    axes = "\t".join(f"{a}{i + 1}" for i in range(8) for a in "XYZ")
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"100\t100\t{len(positions)}\t8\t{units}\t100\t1\t{len(positions)}",
        f"Frame#\tTime\t{names}\t\t",
        f"\t\t{axes}",
        "",
    ]
    for t, frame in enumerate(positions.reshape(len(positions), -1)):
        lines.append("\t".join([str(t + 1), f"{t / 100:.3f}", *("" if np.isnan(v) else f"{v:.6f}" for v in frame)]))
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize(("units", "mm"), [("mm", 1), ("m", 1000)])
def test_trc(tmp_path, units, mm):
    read = read_marker_file(trc(tmp_path / "take.trc", take().positions / mm, units))
    assert (read.markers.labels, read.markers.rate, read.unit_source, read.warnings) == (NAMES, 100, "file", ())
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=2e-3)


# --- refusals ----------------------------------------------------------------------------------------------------


def test_missing_file_and_unknown_suffix(tmp_path):
    assert "no such file" in refusal(tmp_path / "take.c3d")
    (tmp_path / "take.fbx").write_text("x")
    assert ".c3d .trc .csv" in refusal(tmp_path / "take.fbx")


def test_all_empty_frames_are_refused(tmp_path):
    path = wide_csv(tmp_path / "take.csv", np.full((4, 8, 3), np.nan))
    assert "all 4 frames are empty" in refusal(path)
    path = custom_c3d(tmp_path / "take.c3d", list(NAMES), np.zeros((4, 8, 3)))
    assert "all 4 frames are empty" in refusal(path)


def test_fewer_than_six_markers_are_refused(tmp_path):
    assert "only 5 marker(s)" in refusal(wide_csv(tmp_path / "take.csv", take().positions[:, :5]))
    write_c3d(tmp_path / "take.c3d", Markers(take().positions[:, :5], NAMES[:5], 60.0))
    assert "at least 6" in refusal(tmp_path / "take.c3d")
    positions = take().positions
    positions[:, :3] = np.nan
    assert "only 5 marker(s)" in refusal(wide_csv(tmp_path / "take.csv", positions))


def test_a_marker_never_seen_is_told(tmp_path):
    positions = take().positions
    positions[:, 3] = np.nan
    read = read_marker_file(wide_csv(tmp_path / "take.csv", positions))
    assert read.warnings[0].endswith("never seen: M3")


def test_labels_that_come_twice_are_numbered(tmp_path):
    path = custom_c3d(tmp_path / "take.c3d", ["M0", *NAMES[:7]], np.tile(FACE, (3, 1, 1)))
    read = read_marker_file(path)
    assert read.markers.labels == ("M0_1", "M0_2", *NAMES[1:7])
    assert read.warnings == (f"{path}: 2 markers are called M0; numbered M0_1 to M0_2 in the file's order",)


def test_columns_that_come_twice_are_numbered(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions, lambda n, a: f"{n.replace('M1', 'M0')}_{a}")
    assert read_markers(path).labels == ("M0_1", "M0_2", *NAMES[2:])


def test_a_label_twice_in_one_frame_of_a_long_table_is_refused(tmp_path):
    rows = [(t, n, *FACE[i] + t) for t in range(4) for i, n in enumerate(NAMES)]
    lines = ["frame,label,x,y,z"] + [",".join(map(str, row)) for row in rows]
    path = tmp_path / "long.csv"
    path.write_text("\n".join([*lines, "0,M1,1,2,3"]))
    assert "row 34: duplicate marker labels: M1 comes twice in frame 0" in refusal(path)
    path.write_text("\n".join(line.replace("M1", "M0") for line in lines))
    assert read_markers(path).labels == ("M0_1", "M0_2", *NAMES[2:])


def test_markers_all_in_one_place_are_refused(tmp_path):
    assert "apart" in refusal(wide_csv(tmp_path / "take.csv", np.ones((3, 8, 3))))


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


def test_a_trc_that_is_none(tmp_path):
    (tmp_path / "take.trc").write_text("hello\n" * 9)
    assert "not a TRC file" in refusal(tmp_path / "take.trc")
    text = trc(tmp_path / "take.trc", take().positions).read_text()
    (tmp_path / "take.trc").write_text("\n".join(text.splitlines()[:5]))
    assert "no marker points" in refusal(tmp_path / "take.trc")


def test_a_failed_write_leaves_the_old_file(tmp_path):
    write_c3d(tmp_path / "take.c3d", take())
    before = (tmp_path / "take.c3d").read_bytes()
    with pytest.raises(Exception):  # noqa: B017, PT011
        write_c3d(tmp_path / "take.c3d", replace(take(), rate="fast"))  # pyright: ignore[reportArgumentType]
    assert (tmp_path / "take.c3d").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["take.c3d"]
    with pytest.raises(BadInput, match="does not exist"):
        write_c3d(tmp_path / "nowhere/take.c3d", take())


# --- a real take -------------------------------------------------------------------------------------------------


@pytest.mark.data
@pytest.mark.parametrize(("subject", "frames", "dot"), [("01", 1714, 0.04328), ("02", 1692, 0.05097)])
def test_a_real_take(subject, frames, dot):
    path = REAL / f"Subject_{subject}.csv"
    if not path.exists():
        pytest.skip(f"{path} is not there")
    read = read_marker_file(path)
    assert read.unit_source == "guessed"
    assert read.markers.positions.shape == (frames, 16, 3)
    assert read.markers.notes is not None
    assert "posed_happy" in read.markers.notes["Stimulustype"]
    assert 0.4 < read.markers.seen.mean() < 0.6
    np.testing.assert_allclose(read.unit_mm, 8 / dot, rtol=0.03)
    assert read_marker_file(path, unit=f"{8 / dot:.3f}").unit_source == "argument"
