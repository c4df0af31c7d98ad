"""C3D in: against another library, dialects by hand, and every refusal with its line."""

import struct

import ezc3d
import numpy as np
import pytest

from marker_files import FACE, NAMES, c3d_bytes, custom_c3d, record, refusal
from mien.io.markers import read_marker_file, read_markers


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


def twin(path) -> np.ndarray:
    """Positions as ezc3d reads them, NaN where the residual is negative."""
    content = ezc3d.c3d(str(path))
    points = content["data"]["points"][:3].transpose(2, 1, 0)
    residual = content["data"]["meta_points"]["residuals"][0].T
    return np.where((residual < 0)[:, :, None], np.nan, points)


@pytest.mark.parametrize("scale", [-1.0, 0.05])
@pytest.mark.parametrize("analog", [0, 6])
def test_twin(tmp_path, scale, analog):
    """Ours and ezc3d's agree on floats and integers, with and without analog channels."""
    positions = FACE + np.random.default_rng(3).normal(0, 1, (20, 8, 3))
    positions[4, 2] = np.nan
    path = tmp_path / "take.c3d"
    path.write_bytes(c3d_bytes(positions, scale=scale, analog=analog))
    ours = read_markers(path).positions
    np.testing.assert_allclose(ours, twin(path), rtol=1e-6)
    np.testing.assert_allclose(ours, positions, atol=1e-4 if scale < 0 else scale)
    assert read_markers(path).labels == NAMES


@pytest.mark.parametrize("scale", [-1.0, 0.05])
@pytest.mark.parametrize("processor", [84, 85, 86])
def test_every_processor(tmp_path, processor, scale):
    """Intel, DEC and MIPS store the same take."""
    positions = np.tile(FACE, (5, 1, 1))
    (tmp_path / "take.c3d").write_bytes(c3d_bytes(positions, processor=processor, scale=scale))
    read = read_marker_file(tmp_path / "take.c3d")
    np.testing.assert_allclose(read.markers.positions, positions, atol=1e-4 if scale < 0 else scale)
    assert (read.markers.labels, read.markers.rate, read.unit_source) == (NAMES, 60.0, "file")


def test_a_negative_residual_is_a_gap(tmp_path):
    positions = np.tile(FACE, (3, 1, 1))
    positions[1, 5] = np.nan
    for scale in (-1.0, 0.05):
        (tmp_path / "take.c3d").write_bytes(c3d_bytes(positions, scale=scale))
        np.testing.assert_array_equal(read_markers(tmp_path / "take.c3d").seen, np.isfinite(positions[:, :, 0]))


def test_labels_in_several_lists_and_points_without_any(tmp_path):
    extra = record(1, "LABELS2", struct.pack("<bBBB", -1, 2, 2, 2) + b"A B ")
    path = tmp_path / "take.c3d"
    positions = np.concatenate([np.tile(FACE, (3, 1, 1)), np.tile(FACE[:3] + 5, (3, 1, 1))], axis=1)
    path.write_bytes(c3d_bytes(positions, labels=NAMES, extra=extra))
    read = read_marker_file(path)
    assert read.markers.labels == (*NAMES, "A", "B")
    assert any("1 of 11 points are not labelled" in line for line in read.warnings)


def test_only_events_is_told(tmp_path):
    extra = record(-4, "EVENT") + record(4, "USED", struct.pack("<bBh", 2, 0, 3))
    (tmp_path / "take.c3d").write_bytes(c3d_bytes(np.zeros((3, 0, 3)), labels=(), extra=extra))
    assert "no marker points, only events" in refusal(tmp_path / "take.c3d")
