"""C3D parameter sections as programs write them, whole and odd: POINT is enough."""

import struct

import numpy as np
import pytest

from marker_files import FACE, NAMES, c3d_bytes, record
from mien.io.markers import read_marker_file
from mien.io.markers.c3d.parameters import read_header

POSITIONS = np.tile(FACE, (4, 1, 1))


def parameters(data: bytes, tmp_path):
    return read_header(tmp_path / "take.c3d", data)[1]


def read(data: bytes, tmp_path):
    path = tmp_path / "take.c3d"
    path.write_bytes(data)
    return read_marker_file(path)


def test_values_of_every_type(tmp_path):
    extra = record(1, "BYTE", struct.pack("<bBb", 1, 0, -3)) + record(
        1, "FLOATS", struct.pack("<bBBff", 4, 1, 2, 0.5, 8)
    )
    extra += record(1, "TEXTS", struct.pack("<bBBB", -1, 2, 3, 2) + b"ab cde")
    extra += record(1, "NONE", struct.pack("<bBB", 2, 1, 0)) + record(1, "NAN", struct.pack("<bBf", 4, 0, np.nan))
    found = parameters(c3d_bytes(POSITIONS, extra=extra), tmp_path)
    assert (found.number("POINT", "BYTE"), found.texts("POINT", "TEXTS")) == (-3.0, ["ab", "cde"])
    np.testing.assert_array_equal(found.groups["POINT"]["FLOATS"], [0.5, 8.0])
    assert found.number("POINT", "NONE") is None
    assert found.number("POINT", "NAN") is None
    assert found.text("POINT", "BYTE") == ""
    assert not found.has("POINT", "ABSENT")


@pytest.mark.parametrize(
    "extra",
    [
        record(7, "ORPHAN", struct.pack("<bBh", 2, 0, 1)),
        record(-9, "EMPTY"),
        record(1, "ODD", struct.pack("<bBh", 3, 0, 1)),
        record(1, "WIDE", struct.pack("<bB", 2, 9) + bytes(9)),
        record(-100, "VENDOR") + record(100, "VALUE", struct.pack("<bBBB", -1, 2, 1, 0)),
    ],
    ids=["parameter without group", "group without parameters", "unknown type", "nine dimensions", "group 100"],
)
def test_odd_records_are_skipped(tmp_path, extra):
    for first in (True, False):
        got = read(c3d_bytes(POSITIONS, extra=extra, extra_first=first), tmp_path)
        assert (got.markers.labels, got.warnings) == (NAMES, ())
        np.testing.assert_allclose(got.markers.positions, POSITIONS, rtol=1e-6)


@pytest.mark.parametrize("blocks", [0, 1, 40, 255])
def test_a_wrong_number_of_blocks_does_no_harm(tmp_path, blocks):
    long = record(1, "DESCRIPTIONS", struct.pack("<bBBB", -1, 2, 100, 12) + b"x" * 1200)
    data = bytearray(c3d_bytes(POSITIONS, extra=long, extra_first=True))
    data[512 + 2] = blocks
    got = read(bytes(data), tmp_path)
    assert (got.markers.labels, got.markers.rate) == (NAMES, 60.0)
    np.testing.assert_allclose(got.markers.positions, POSITIONS, rtol=1e-6)


@pytest.mark.parametrize("step", [0, -3, 32767])
def test_a_way_to_the_next_record_that_leads_nowhere(tmp_path, step):
    """The record's own length leads on."""
    data = bytearray(c3d_bytes(POSITIONS))
    at = data.index(b"RATE") + 4
    data[at : at + 2] = struct.pack("<h", step)
    assert read(bytes(data), tmp_path).markers.labels == NAMES


def test_no_parameters_at_all(tmp_path):
    """The header alone says enough: points by number, rate, frames; the unit is the one that makes a face."""
    data = bytearray(c3d_bytes(POSITIONS))
    data[512 + 4 : 1024] = bytes(508)
    data[512 + 2] = 0
    got = read(bytes(data), tmp_path)
    assert got.markers.labels == tuple(f"U{i + 1}" for i in range(8))
    assert (got.markers.rate, got.unit_mm, got.unit_source) == (60.0, 1.0, "assumed")
    np.testing.assert_allclose(got.markers.positions, POSITIONS, rtol=1e-6)


def test_a_locked_group_and_names_in_small_letters(tmp_path):
    data = c3d_bytes(POSITIONS).replace(b"\x06\x01LABELS", b"\xfa\x01labels")
    assert read(data, tmp_path).markers.labels == NAMES
