"""Live Link Face's packets: what the iPhone app sends to Unreal by UDP, one a frame.

All numbers are big-endian: u8 version (6); the device's name and the subject's, each an i32 length and so many bytes of
UTF-8; the time as i32 frame, f32 part of a frame, i32 numerator and i32 denominator of the rate; u8 count; so many f32:
52 weights in the app's order, then yaw, pitch and roll of the head, of the left eye and of the right one
(`io.live_link_table`).
"""

import struct
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Float32

from ..errors import BadInput
from ..io.live_link_table import EYES, HEAD, SHAPES

VERSION = 6
PORT = 11111
"""Where Unreal listens."""
VALUES = len(SHAPES) + len(HEAD) + len(EYES)
_LONGEST_NAME = 1024
"""Bytes: longer ones are damage."""
_FINEST_RATE = 1001
"""Denominators up to this one: 60000/1001 a second is a rate of films."""


@dataclass(frozen=True)
class LiveLinkPacket:
    """One frame."""

    subject: str
    values: Float32[np.ndarray, " values"]
    """Weights, then angles in radians, in the app's order; 61 of them."""
    frame: int
    """Count of frames at `rate`."""
    rate: Fraction
    """Frames a second."""
    part: float = 0.0
    """Of a frame, 0..1."""
    device: str = "mien"

    @property
    def time(self) -> float:
        """Seconds."""
        return float((self.frame + self.part) / self.rate)


def encode(packet: LiveLinkPacket) -> bytes:
    """A packet's bytes."""
    head = struct.pack(">B", VERSION) + _text(packet.device) + _text(packet.subject)
    clock = struct.pack(">ifii", packet.frame, packet.part, packet.rate.numerator, packet.rate.denominator)
    return head + clock + struct.pack(">B", len(packet.values)) + packet.values.astype(">f4").tobytes()


def decode(data: bytes) -> LiveLinkPacket:
    """A packet from its bytes. Values that are not there are 0, more than 61 are left out.

    Raises:
        BadInput: cut off, not such a packet, or a value that is not finite.
    """
    try:
        version = data[0]
        device, at = _read_text(data, 1)
        subject, at = _read_text(data, at)
        frame, part, numerator, denominator = struct.unpack_from(">ifii", data, at)
        at += 16
        count = data[at]
        values = np.frombuffer(data, ">f4", count, at + 1).astype(np.float32)
        rate = Fraction(numerator, denominator)
    except (struct.error, IndexError, ValueError, ZeroDivisionError) as error:
        raise BadInput(f"a packet of {len(data)} bytes is no Live Link Face frame ({error})") from error
    if rate <= 0 or not np.isfinite(values).all() or not np.isfinite(part):
        raise BadInput(f"a Live Link Face packet (version {version}) holds a value that is not finite, or no rate")
    full = np.zeros(VALUES, np.float32)
    full[: min(count, VALUES)] = values[:VALUES]
    return LiveLinkPacket(subject, full, frame, rate, float(part), device)


def rate_of(rate: float) -> Fraction:
    """A rate as a fraction whose numbers are small enough for a packet."""
    return Fraction(rate).limit_denominator(_FINEST_RATE)


def _text(text: str) -> bytes:
    raw = text.encode()
    return struct.pack(">i", len(raw)) + raw


def _read_text(data: bytes, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from(">i", data, at)
    end = at + 4 + length
    if not 0 <= length <= _LONGEST_NAME or end > len(data):
        raise ValueError(f"a name of {length} bytes")
    return data[at + 4 : end].decode(errors="replace"), end
