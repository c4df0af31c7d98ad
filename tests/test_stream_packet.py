"""Live Link Face's packets, byte by byte, and a real recording."""

import struct
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.live_link_table import NAMES
from mien.stream.packet import VALUES, LiveLinkPacket, decode, encode, rate_of
from mien.stream.receive import read_recording, take_of

RECORDING = Path(__file__).resolve().parents[2] / "shared/data/live_link/dao.gesichter"


def packet(**change) -> LiveLinkPacket:
    values = np.linspace(0, 1, VALUES, dtype=np.float32)
    usual = {"subject": "Füße", "values": values, "frame": 90, "rate": Fraction(60), "part": 0.25}
    return LiveLinkPacket(**usual | change)


def test_bytes_by_hand():
    data = encode(packet(device="ab", subject="c", values=np.float32([0.5, -1])))
    by_hand = b"\x06" + b"\0\0\0\x02ab" + b"\0\0\0\x01c" + b"\0\0\0\x5a" + struct.pack(">f", 0.25)
    assert data == by_hand + b"\0\0\0\x3c" + b"\0\0\0\x01" + b"\x02" + b"\x3f\0\0\0" + b"\xbf\x80\0\0"


def test_out_and_in():
    back = decode(encode(packet()))
    assert (back.subject, back.device, back.frame, back.rate, back.part) == ("Füße", "mien", 90, 60, 0.25)
    np.testing.assert_array_equal(back.values, packet().values)
    assert back.time == pytest.approx(90.25 / 60)


def test_fewer_values_are_filled_and_more_left_out():
    assert decode(encode(packet(values=np.ones(52, np.float32)))).values[52:].tolist() == [0] * 9
    assert len(decode(encode(packet(values=np.ones(80, np.float32)))).values) == VALUES


def test_every_cut_and_damage_is_told():
    data = encode(packet())
    for length in range(len(data)):
        with pytest.raises(BadInput):
            decode(data[:length])
    for wrong in (packet(values=np.full(61, np.nan, np.float32)), packet(part=float("inf"))):
        with pytest.raises(BadInput, match="not finite"):
            decode(encode(wrong))


def test_rates_of_films():
    assert rate_of(59.94005994) == Fraction(60000, 1001)
    assert rate_of(30.0) == 30


@pytest.mark.data
@pytest.mark.skipif(not RECORDING.is_file(), reason="the recording of packets is not there")
def test_a_recording_of_another_program_decodes_and_encodes_to_the_same_bytes():
    packets = read_recording(RECORDING)
    assert len(packets) == 180
    assert {p.subject for p in packets} == {"LLV Default Device"}
    assert decode(encode(packets[7])).values.tolist() == packets[7].values.tolist()
    take = take_of(packets)
    assert take.rate == 60
    assert take.weights.min() >= 0
    assert take.weights.max() <= 1
    assert np.ptp(take.weights[:, NAMES.index("jawOpen")]) > 0.02
    assert np.abs(take.head).max() < 0.6
