"""Frames to their receivers, on the clock."""

import socket
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from ..errors import BadInput
from .face_frame import FaceFrame
from .packet import LiveLinkPacket, encode, rate_of


@runtime_checkable
class FrameSender(Protocol):
    """Whatever takes frames."""

    def send(self, frame: FaceFrame) -> None:
        """Take one."""
        ...


class UdpSender:
    """Sends each frame as one datagram to one address. A receiver that is not there loses it, and nothing stops."""

    def __init__(self, address: tuple[str, int], encode_frame: Callable[[FaceFrame], bytes]):
        """Raises BadInput where the host is not known."""
        host, port = address
        try:
            family, _, _, _, self._to = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        except OSError as error:
            raise BadInput(f"{host}: no such host ({error}); give a name or an address") from error
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._encode = encode_frame
        self.lost = 0
        """Frames that the system would not send."""
        self.fault = ""
        """Why, the last time."""

    def send(self, frame: FaceFrame) -> None:
        """Send a frame, or count it as lost."""
        try:
            self._socket.sendto(self._encode(frame), self._to)
        except OSError as error:
            self.lost, self.fault = self.lost + 1, error.strerror or str(error)

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()


def live_link_bytes(subject: str) -> Callable[[FaceFrame], bytes]:
    """How a frame becomes a Live Link Face packet of this subject."""

    def packed(frame: FaceFrame) -> bytes:
        return encode(LiveLinkPacket(subject, frame.row.astype(np.float32), frame.number, rate_of(frame.rate)))

    return packed


def parse_address(text: str, port: int) -> tuple[str, int]:
    """`HOST:PORT`, `HOST`, `:PORT` or `[IPv6]:PORT`; without a host this machine, without a port `port`.

    Raises:
        BadInput: a port that is none.
    """
    host, colon, last = text.rpartition(":") if not text.endswith("]") and text.count(":") != 0 else (text, "", "")
    if text.count(":") > 1 and "[" not in text:
        host, colon, last = text, "", ""
    if colon and not (last.isdecimal() and 0 < int(last) < 2**16):
        raise BadInput(f"{text}: {last or 'nothing'} is no port; write HOST:PORT, such as 127.0.0.1:{port}")
    return host.strip("[]") or "127.0.0.1", int(last) if colon else port


@dataclass(frozen=True)
class Sent:
    """What became of a stream."""

    frames: int
    skipped: int
    """Frames that were left out because their time had passed."""


def send_on_time(
    frames: Iterable[FaceFrame],
    senders: Sequence[FrameSender],
    seconds: float | None = None,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
    count: Callable[[int], None] = lambda sent: None,
) -> Sent:
    """Send each frame at its time, until they end or `seconds` have passed; one whose successor is due is left out.

    `count` hears how many are sent, after each.
    """
    start = clock()
    sent = skipped = 0
    for frame in frames:
        due = frame.number / frame.rate
        if seconds is not None and due >= seconds:
            break
        late = clock() - start - due
        if late > 1 / frame.rate:
            skipped += 1
            continue
        if late < 0:
            sleep(-late)
        for sender in senders:
            sender.send(frame)
        sent += 1
        count(sent)
    return Sent(sent, skipped)


def send_as_they_come(
    frames: Iterable[FaceFrame], senders: Sequence[FrameSender], count: Callable[[int], None]
) -> Sent:
    """Send each frame of a live source at once."""
    sent = 0
    for frame in frames:
        for sender in senders:
            sender.send(frame)
        sent += 1
        count(sent)
    return Sent(sent, 0)
