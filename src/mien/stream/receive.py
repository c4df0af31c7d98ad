"""Live Link Face packets from the network, and what they come to as a take."""

import gzip
import socket
import struct
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from ..errors import BadInput
from ..files import existing
from ..io.live_link_table import HEAD, NAMES
from ..io.livelink import LiveLinkTake
from .face_frame import FaceFrame
from .packet import LiveLinkPacket, decode

_LARGEST = 65536
"""Bytes of a datagram at most."""
_LOOK_S = 0.25
"""A wait for packets is cut into pieces of this length, so that Ctrl-C is heard at once on every system."""
RECORDING = ".gesichter"
"""Recordings of packets: u8 version, u32 count, then each packet behind its u32 length; big-endian, gzip."""


class LiveLinkReceiver:
    """Listens for packets on a port."""

    def __init__(self, address: tuple[str, int]):
        """Raises BadInput where the port is taken or the host is not this machine's."""
        self.address = address
        family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind(address)
        except OSError as error:
            self._socket.close()
            told = f"{address[0]}:{address[1]}: cannot listen there ({error.strerror})"
            raise BadInput(f"{told}; stop what listens there, or choose another port") from error
        self.address = self._socket.getsockname()[:2]
        self.damaged = 0
        """Datagrams that were no frames."""

    def packets(
        self, seconds: float, patience: float, clock: Callable[[], float] = time.monotonic
    ) -> Iterator[LiveLinkPacket]:
        """Packets of the first subject that is heard, as they come, for `seconds` from the first one on.

        Ends where none comes for `patience` seconds. A second subject is left out.
        """
        subject, end, heard = None, None, clock()
        while (end is None or clock() < end) and clock() - heard < patience:
            self._socket.settimeout(_LOOK_S)
            try:
                packet = decode(self._socket.recv(_LARGEST))
            except TimeoutError:
                continue
            except BadInput:
                self.damaged += 1
                continue
            subject = packet.subject if subject is None else subject
            if packet.subject == subject:
                heard = clock()
                end = heard + seconds if end is None else end
                yield packet

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()


def read_recording(path: str | Path) -> list[LiveLinkPacket]:
    """The packets of a `.gesichter` file; one that is cut off gives what is whole.

    Raises:
        BadInput: missing, damaged, or without a packet.
    """
    path = existing(path)
    try:
        data = gzip.decompress(path.read_bytes())
        (count,) = struct.unpack_from(">I", data, 1)
    except (OSError, EOFError, struct.error, ValueError) as error:
        raise BadInput(f"{path}: is no recording of Live Link Face packets ({error})") from error
    packets, at = [], 5
    while len(packets) < count and at + 4 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        if at + 4 + length > len(data):
            break
        packets.append(decode(data[at + 4 : at + 4 + length]))
        at += 4 + length
    if not packets:
        raise BadInput(f"{path}: holds no frame; record again")
    return packets


def take_of(packets: Sequence[LiveLinkPacket]) -> LiveLinkTake:
    """Packets as a take at an even rate, sorted by time, the first of equal ones; lost ones hold the last value."""
    frames = np.array([packet.frame for packet in packets])
    order = np.unique(frames, return_index=True)[1]
    frames = frames[order]
    step = max(1, round(float(np.median(np.diff(frames))))) if len(frames) > 1 else 1
    places = np.round((frames - frames[0]) / step).astype(int)
    places, first = np.unique(places, return_index=True)
    rows = np.stack([packets[i].values for i in order[first]]).astype(np.float64)
    tracked = np.zeros(places[-1] + 1, bool)
    tracked[places] = True
    held = rows[np.searchsorted(places, np.arange(len(tracked)), side="right") - 1]
    weights, head, eyes = np.split(held, [len(NAMES), len(NAMES) + len(HEAD)], axis=1)
    return LiveLinkTake(NAMES, weights, head, eyes, float(packets[0].rate / step), tracked)


def frames_of(packets: Iterator[LiveLinkPacket]) -> Iterator[FaceFrame]:
    """Packets as frames to be sent onwards, each as it comes."""
    for number, packet in enumerate(packets):
        rotation = take_of([packet]).rotations()[0]
        yield FaceFrame(number, float(packet.rate), packet.values.astype(np.float64), rotation)
