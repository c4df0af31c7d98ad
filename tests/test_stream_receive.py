"""Live Link Face packets in: over loopback, with loss, damage and a second phone; and from a recording."""

import gzip
import socket
import struct
from fractions import Fraction
from itertools import count

import numpy as np
import pytest

from gltf_files import performance
from mien.errors import BadInput
from mien.io.livelink import live_link_rows
from mien.stream import receive
from mien.stream.face_frame import face_frames
from mien.stream.packet import VALUES, LiveLinkPacket, encode
from mien.stream.receive import LiveLinkReceiver, frames_of, read_recording, take_of
from mien.stream.send import live_link_bytes


def packets(numbers, subject: str = "me") -> list[LiveLinkPacket]:
    return [LiveLinkPacket(subject, np.full(VALUES, n / 1000, np.float32), n, Fraction(60)) for n in numbers]


def test_what_is_sent_is_heard(monkeypatch):
    monkeypatch.setattr(receive, "_LOOK_S", 0.01)
    play = performance(8)
    receiver = LiveLinkReceiver(("127.0.0.1", 0))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as phone:
        phone.sendto(b"noise", receiver.address)
        for frame in face_frames(play):
            phone.sendto(live_link_bytes("me")(frame), receiver.address)
            phone.sendto(live_link_bytes("other")(frame), receiver.address)
    heard = list(receiver.packets(seconds=1e6, patience=20, clock=count().__next__))
    receiver.close()
    assert receiver.damaged == 1
    take = take_of(heard)
    np.testing.assert_allclose(np.c_[take.weights, take.head, take.eyes], live_link_rows(play), atol=1e-6)
    assert take.rate == play.rate


def test_a_taken_port_is_told():
    first = LiveLinkReceiver(("127.0.0.1", 0))
    with pytest.raises(BadInput, match="cannot listen there"):
        LiveLinkReceiver(first.address)
    first.close()


def test_lost_doubled_and_late_packets():
    take = take_of(packets([10, 12, 11, 11, 15]))
    assert take.rate == 60
    assert take.tracked.tolist() == [True, True, True, False, False, True]
    np.testing.assert_allclose(take.weights[:, 0], [0.010, 0.011, 0.012, 0.012, 0.012, 0.015], atol=1e-7)


def test_a_phone_that_sends_every_other_frame():
    take = take_of(packets(range(0, 20, 2)))
    assert take.rate == 30
    assert take.tracked.all()


def test_frames_go_onwards():
    sent = packets(range(3))
    frames = list(frames_of(iter(sent)))
    np.testing.assert_allclose(frames[2].row, sent[2].values)
    assert [frame.number for frame in frames] == [0, 1, 2]


def recording(path, kept: list[bytes], count: int):
    body = b"".join(struct.pack(">I", len(data)) + data for data in kept)
    path.write_bytes(gzip.compress(b"\x06" + struct.pack(">I", count) + body))
    return path


def test_recordings_whole_cut_off_and_damaged(tmp_path):
    data = [encode(packet) for packet in packets(range(5))]
    assert len(read_recording(recording(tmp_path / "a.gesichter", data, 5))) == 5
    assert len(read_recording(recording(tmp_path / "b.gesichter", data[:3], 5))) == 3
    for content, told in ((b"noise", "no recording"), (gzip.compress(b"\x06\0\0\0\0"), "no frame")):
        (tmp_path / "c.gesichter").write_bytes(content)
        with pytest.raises(BadInput, match=told):
            read_recording(tmp_path / "c.gesichter")
