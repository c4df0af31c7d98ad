"""TSV of Track Manager: column header, frame and time are options."""

import numpy as np
import pytest

from marker_files import NAMES, cells, refusal, take
from mien.io.markers import read_marker_file

KEYS = [["NO_OF_FRAMES", "5"], ["NO_OF_CAMERAS", "10"], ["NO_OF_MARKERS", "8"], ["FREQUENCY", "60"]]
KEYS += [["TIME_STAMP", "2024-01-19, 10:19:43"], ["DATA_INCLUDED", "3D"], ["EVENT", "clap", "3", "0.05"]]


def export(path, columns=False, frame=False, time=False, trailing=False, keys=KEYS, names=NAMES):
    lines = [*keys, ["MARKER_NAMES", *names]]
    extra = ["Frame"] * frame + ["Time"] * time
    if columns:
        lines.append([*extra, *(f"{name} {axis}" for name in names for axis in "XYZ")])
    for t, row in enumerate(cells(take().positions)):
        lines.append([*[str(t + 1)] * frame, *[f"{t / 60:.5f}"] * time, *row])
    path.write_text("\n".join("\t".join(line) + "\t" * trailing for line in lines) + "\n")
    return path


@pytest.mark.parametrize("trailing", [False, True])
@pytest.mark.parametrize("columns", [False, True])
@pytest.mark.parametrize(("frame", "time"), [(False, False), (True, False), (False, True), (True, True)])
def test_every_set_of_options(tmp_path, columns, frame, time, trailing):
    read = read_marker_file(export(tmp_path / "take.tsv", columns, frame, time, trailing))
    assert (read.markers.labels, read.markers.rate, read.unit_mm, read.unit_source) == (NAMES, 60, 1.0, "file")
    np.testing.assert_allclose(read.markers.positions, take().positions, atol=1e-5)
    assert read.warnings == ()


def test_bodies_are_refused(tmp_path):
    keys = [["NO_OF_FRAMES", "5"], ["NO_OF_BODIES", "1"], ["FREQUENCY", "60"], ["DATA_INCLUDED", "6D"]]
    assert "rigid bodies (6D), no markers" in refusal(export(tmp_path / "take.tsv", keys=keys))


def test_names_that_do_not_fit_the_columns_are_refused(tmp_path):
    keys = [key for key in KEYS if key[0] != "NO_OF_MARKERS"]
    assert "24 columns for 6 markers" in refusal(
        export(tmp_path / "take.tsv", keys=keys, names=NAMES[:6]).rename(tmp_path / "cut.tsv")
    )


def test_a_header_without_rows_is_told(tmp_path):
    (tmp_path / "take.tsv").write_text("\n".join("\t".join(key) for key in KEYS))
    assert "no row of numbers" in refusal(tmp_path / "take.tsv")
