"""`mien track livelink`: packets of the Live Link Face app become an animated face."""

from collections.abc import Iterator
from pathlib import Path

from ..errors import BadInput
from ..io.performances import write_any_performance
from ..stream.packet import PORT, LiveLinkPacket
from ..stream.receive import LiveLinkReceiver, take_of
from ..stream.send import parse_address
from .play import play_on, tell

PATIENCE_S = 10.0
"""How long no packet may come before the recording ends."""


def record_live_link(listen: str | None, rig: Path | None, output: Path, seconds: float) -> None:
    """Record for `seconds` from the first packet on, or until Ctrl-C, and write it on the rig.

    Raises:
        BadInput: the port is taken, or no packet came.
    """
    receiver = open_receiver(listen)
    try:
        packets = collect(receiver.packets(seconds, PATIENCE_S))
    finally:
        receiver.close()
    if not packets:
        damaged = f" ({receiver.damaged} others did)" if receiver.damaged else ""
        raise BadInput(
            f"no Live Link Face packet came in {PATIENCE_S:g} s{damaged}: in the app, Settings > Live Link > Add "
            f"Target, give this computer's address and port {receiver.address[1]}"
        )
    take = take_of(packets)
    if rig is not None:
        play_on(take.alone(), rig, output, {}, correctives=False)
    else:
        from ..faces.bundled import load_face

        face = load_face()
        write_any_performance(output, take.to_performance(face.rig))
    frames = len(take.weights)
    lost = frames - int(take.tracked.sum())
    line = f"{output}: {frames} frames at {take.rate:g} a second of {packets[0].subject}"
    print(f"{line}, {lost} lost on the way" if lost else line)


def open_receiver(listen: str | None) -> LiveLinkReceiver:
    """The port, open, and told which it is."""
    address = ("0.0.0.0", PORT) if listen is None else parse_address(listen, PORT)
    receiver = LiveLinkReceiver(address)
    host, port = receiver.address
    where = "every network of this computer" if host in ("0.0.0.0", "::") else host
    tell(f"listening on UDP port {port}, {where}; Ctrl-C ends")
    return receiver


def collect(coming: Iterator[LiveLinkPacket]) -> list[LiveLinkPacket]:
    """Packets until they end, or Ctrl-C."""
    packets: list[LiveLinkPacket] = []
    try:
        for packet in coming:
            if not packets:
                tell(f"recording {packet.subject}")
            packets.append(packet)
    except KeyboardInterrupt:
        tell("stopped; what was recorded is kept")
    return packets
