"""On the clock: frames at their times, late ones left out, receivers that are gone."""

import pytest

from gltf_files import performance
from mien.errors import BadInput
from mien.stream.face_frame import face_frames, sampled
from mien.stream.packet import decode
from mien.stream.send import UdpSender, live_link_bytes, parse_address, send_on_time


class Clock:
    def __init__(self, busy: float = 0.0):
        self.now, self.busy = 100.0, busy

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


class Sink:
    def __init__(self, clock: Clock):
        self.clock, self.times, self.numbers = clock, [], []

    def send(self, frame) -> None:
        self.times.append(round(self.clock.now - 100, 6))
        self.numbers.append(frame.number)
        self.clock.now += self.clock.busy


def test_each_frame_leaves_at_its_time():
    clock = Clock()
    sink = Sink(clock)
    sent = send_on_time(face_frames(performance(10, 10.0)), [sink], clock=clock, sleep=clock.sleep)
    assert sink.times == [round(i / 10, 6) for i in range(10)]
    assert (sent.frames, sent.skipped) == (10, 0)


def test_what_is_late_is_left_out_and_time_is_kept():
    clock = Clock(busy=0.25)
    sink = Sink(clock)
    sent = send_on_time(face_frames(performance(20, 10.0)), [sink], clock=clock, sleep=clock.sleep)
    assert sent.skipped > 5
    assert sink.times[-1] - sink.numbers[-1] / 10 <= 0.1 + 1e-9


def test_a_loop_ends_with_its_time():
    clock = Clock()
    sink = Sink(clock)
    endless = sampled(face_frames(performance(5, 10.0)), None, loop=True)
    assert send_on_time(endless, [sink], seconds=3.0, clock=clock, sleep=clock.sleep).frames == 30


def test_a_receiver_that_is_gone_stops_nothing():
    frames = face_frames(performance(3))
    sender = UdpSender(("127.0.0.1", 9), live_link_bytes("me"))
    for frame in frames:
        sender.send(frame)
    sender.close()
    sender.send(frames[0])
    assert sender.lost == 1
    assert sender.fault


def test_live_link_bytes_bear_the_subject_and_the_time():
    frame = face_frames(performance(3, 29.97))[2]
    packet = decode(live_link_bytes("me")(frame))
    assert packet.subject == "me"
    assert packet.time == pytest.approx(2 / 29.97, rel=1e-4)


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("localhost:5000", ("localhost", 5000)),
        ("10.0.0.2", ("10.0.0.2", 7)),
        (":9000", ("127.0.0.1", 9000)),
        ("[::1]:80", ("::1", 80)),
        ("[::1]", ("::1", 7)),
        ("fe80::1", ("fe80::1", 7)),
    ],
)
def test_addresses(text, address):
    assert parse_address(text, 7) == address


@pytest.mark.parametrize("text", ["host:", "host:x", "host:0", "host:70000", "host:-1"])
def test_ports_that_are_none(text):
    with pytest.raises(BadInput, match="is no port"):
        parse_address(text, 7)


def test_a_host_that_is_none():
    with pytest.raises(BadInput, match="no such host"):
        UdpSender(("no host of this name", 1), live_link_bytes("me"))
