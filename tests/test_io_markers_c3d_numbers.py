"""Numbers of three processors, by hand."""

import struct

import numpy as np
import pytest

from mien.io.markers.c3d.numbers import DEC, INTEL, MIPS, floats, one_float, words


def test_words():
    assert words(b"\x01\x00\xff\xff\x07", INTEL).tolist() == [1, -1]
    assert words(b"\x01\x00\xff\xff", DEC).tolist() == [1, -1]
    assert words(b"\x00\x01\xff\xff", MIPS).tolist() == [1, -1]


@pytest.mark.parametrize("processor", [INTEL, MIPS])
def test_ieee_floats(processor):
    data = struct.pack((">" if processor == MIPS else "<") + "3f", 1.5, -2e10, 0.0)
    np.testing.assert_allclose(floats(data + b"\x00", processor), [1.5, -2e10, 0.0], rtol=1e-7)


def test_vax_floats():
    """VAX 1.0 is 0x4080 in its first word: sign, exponent 129, no fraction."""
    np.testing.assert_allclose(floats(b"\x80\x40\x00\x00", DEC), [1.0])
    np.testing.assert_allclose(floats(b"\x20\xc1\x00\x00", DEC), [-2.5])
    np.testing.assert_allclose(floats(bytes(4), DEC), [0.0])


def test_one_float():
    assert one_float(struct.pack("<f", np.inf), INTEL) == 0.0
    assert one_float(b"\x00", INTEL) == 0.0
    assert one_float(struct.pack("<f", 60), INTEL) == 60.0
