"""CSV of Nexus: the section Trajectories among others."""

import numpy as np
import pytest

from marker_files import NAMES, cells, refusal, take
from mien.io.markers import read_marker_file


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


DEVICES = ["Devices", "600", ",,AMTI - Force,,", "Frame,Sub Frame,Fx,Fy,Fz", ",,N,N,N"]
DEVICES += [f"{t + 1},{s},0.1,0.2,0.3" for t in range(5) for s in range(10)]
MODEL = ["Model Outputs", "120", ",,Jane:HeadAngles,,", "Frame,Sub Frame,X,Y,Z", ",,deg,deg,deg"]
MODEL += [f"{t + 1},0,{t},{t},{t}" for t in range(5)]
EVENTS = ["Events", "120", "Subject,Context,Name,Time (s),Description", "Jane,Left,Foot Strike,0.02,none"]


def trajectories() -> list[str]:
    names = ["", "", *(cell for name in NAMES for cell in (f"Jane:{name}", "", ""))]
    lines = ["Trajectories", "120", ",".join(names), ",".join(["Frame", "Sub Frame", *"XYZ" * 8])]
    lines += [",".join(["", "", *["mm"] * 24])]
    return lines + [",".join([str(t + 1), "0", *row]) for t, row in enumerate(cells(take().positions))]


@pytest.mark.parametrize(
    "order",
    ["TD", "DT", "MT", "TM", "EDMT", "DTM"],
)
def test_sections_in_any_order(tmp_path, order):
    sections = {"D": DEVICES, "M": MODEL, "E": EVENTS, "T": trajectories()}
    text = "\n\n".join("\n".join(sections[key]) for key in order)
    (tmp_path / "take.csv").write_text(text)
    read = read_marker_file(tmp_path / "take.csv")
    assert (read.markers.labels, read.markers.rate, read.unit_source, read.warnings) == (NAMES, 120, "file", ())
    assert read.markers.notes is None
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=1e-5)


def test_trailing_commas_as_spreadsheets_leave_them(tmp_path):
    lines = [*DEVICES, "", *trajectories()]
    (tmp_path / "take.csv").write_text("\n".join(line + "," * (30 - line.count(",")) for line in lines))
    np.testing.assert_allclose(read_marker_file(tmp_path / "take.csv").markers.positions, take().positions, atol=1e-5)


def test_the_older_form(tmp_path):
    """Titles in capitals, the rate with its unit, Field # and no sub-frames."""
    names = ["", *(cell for name in NAMES for cell in (f"Jane:{name}", "", ""))]
    lines = ["ANALOG", "1080,Hz", "Sample #,Fz1,Fz2,Fz3", ",(N),(N),(N)", "1,0.1,0.2,0.3", "", "TRAJECTORIES", "120,Hz"]
    lines += [",".join(names), ",".join(["Field #", *"XYZ" * 8]), ",".join(["", *["(mm)"] * 24])]
    lines += [",".join([str(t + 1), *row]) for t, row in enumerate(cells(take().positions))]
    (tmp_path / "take.csv").write_text("\n".join(lines))
    read = read_marker_file(tmp_path / "take.csv")
    assert (read.markers.labels, read.markers.rate, read.unit_source, read.warnings) == (NAMES, 120, "file", ())
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=1e-5)


def test_no_trajectories_is_told(tmp_path):
    (tmp_path / "take.csv").write_text("\n".join([*DEVICES, "", *MODEL]))
    assert "no section Trajectories, only devices, model outputs" in refusal(tmp_path / "take.csv")
