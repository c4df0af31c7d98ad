"""`mien stream`: a face to avatar programs and engines, frame by frame."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import BadInput
from ..extras import require
from ..files import existing
from ..io.markers import READERS as MARKERS
from ..io.performances import READ as FACES
from ..io.performances import read_any_performance
from ..stream import packet, vmc
from ..stream.face_frame import FaceFrame, face_frames, sampled
from ..stream.receive import RECORDING, frames_of, read_recording, take_of
from ..stream.send import Sent, UdpSender, live_link_bytes, parse_address, send_as_they_come, send_on_time
from .options import refuse_outside, refuse_unused, verb
from .play import tell
from .record_live_link import PATIENCE_S, open_receiver
from .shared_options import CAMERA, LIVE_LINK, CameraOptions, PicturesReading

RATES = 0.1, 1000.0
"""Frames a second that can be sent."""


@dataclass(frozen=True)
class Receivers:
    """Where frames go."""

    vmc: str | None = None
    """HOST:PORT of a VMC receiver (VSeeFace, Warudo, VNyan, Unity, Blender); without a port 39539."""
    livelink: str | None = None
    """HOST:PORT of Unreal (Live Link Face); without a port 11111."""
    subject: str = "mien"
    """The subject's name in Unreal."""
    capitals: bool = False
    """Spell VMC's shapes `JawOpen`, as avatars for Perfect Sync have them, not `jawOpen`."""


@dataclass(frozen=True)
class Pace:
    """How a file is played."""

    loop: bool = False
    """Over and over, until Ctrl-C."""
    fps: float | None = None
    """Frames a second; by default the performance's."""


@verb
def stream(
    source: Path,
    *,
    to: Annotated[Receivers, Parameter(name="*")] = Receivers(),
    pace: Annotated[Pace, Parameter(name="*")] = Pace(),
    seconds: float | None = None,
    rig: Path | None = None,
    listen: str | None = None,
    device: str | None = None,
    page: bool = False,
) -> None:
    """A face out over the network: VMC for avatar programs, Live Link Face for Unreal.

    Frames leave on the clock as UDP, to as many receivers as are named. A receiver that is not there, or goes and comes
    again, stops nothing. Ctrl-C ends it.

    Parameters
    ----------
    source
        A performance (.glb, .usd), a Live Link Face .csv, a recording of packets (.gesichter); a video or an RGB-D
        take, tracked as it plays; or a word: live (this computer's camera), livelink (the iPhone app, sent on).
    seconds
        End after so long.
    rig
        For what is tracked: the person's rig; without it the bundled average face.
    listen
        For livelink: where packets come in, HOST:PORT; by default port 11111 on every network of this computer.
    device
        For live: which camera, as FFmpeg calls it; without it the first.
    page
        For what is tracked: show it in the browser too, beside the sensor's picture; its calibrate button makes the
        face that is held then the neutral of what is sent.
    """
    word = str(source)
    tracked = word == CAMERA or is_taken(source)
    _refuse(word, tracked)
    refuse_outside("pace__fps", pace.fps, *RATES)
    senders = open_senders(to)
    shown = Counter(to)
    try:
        if word == LIVE_LINK:
            sent = send_as_they_come(heard(listen, seconds), senders, shown)
        elif tracked:
            frames = looked_at(source, rig, seconds, device, page)
            sent = send_as_they_come(frames, senders, shown)
        else:
            frames = sampled(recorded(source), pace.fps, pace.loop)
            sent = send_on_time(frames, senders, seconds, count=shown)
    except KeyboardInterrupt:
        sent = Sent(shown.frames, 0)
    finally:
        for sender in senders:
            sender.close()
    tell_sent(sent, senders)


def _refuse(word: str, tracked: bool) -> None:
    """Options that this source does not heed."""
    if word == LIVE_LINK or tracked:
        refuse_unused("for what comes by itself", "pace")
    if word != LIVE_LINK:
        refuse_unused("without livelink", "listen")
    if word != CAMERA:
        refuse_unused("without live", "device")
    if not tracked:
        refuse_unused("for what is not tracked", "rig", "page")


def is_taken(source: Path) -> bool:
    """Whether a source is pictures, which are tracked."""
    suffix = source.suffix.lower()
    if suffix in MARKERS and suffix != ".csv":
        raise BadInput(f"{source}: a marker take; `mien solve {source} -o perf.glb` first, then stream perf.glb")
    return str(source) != LIVE_LINK and suffix not in (*FACES, ".csv", RECORDING)


def open_senders(to: Receivers) -> list[UdpSender]:
    """One a receiver.

    Raises:
        BadInput: none is named, a host is not known, or the extra is missing.
    """
    senders = []
    if to.vmc is not None:
        require("pythonosc", "stream")
        address = parse_address(to.vmc, vmc.PORT)
        senders.append(UdpSender(address, lambda frame: vmc.encode_frame(frame, to.capitals)))
    if to.livelink is not None:
        address = parse_address(to.livelink, packet.PORT)
        senders.append(UdpSender(address, live_link_bytes(to.subject)))
    if not senders:
        raise BadInput("stream: name a receiver: --vmc HOST or --livelink HOST (127.0.0.1 is this computer)")
    return senders


def recorded(source: Path) -> list[FaceFrame]:
    """Frames of a file."""
    suffix = existing(source).suffix.lower()
    if suffix == RECORDING:
        return face_frames(take_of(read_recording(source)).alone())
    if suffix == ".csv":
        from ..io.livelink import read_live_link

        take = read_live_link(source)
        for note in take.notes:
            tell(note)
        return face_frames(take.alone())
    return face_frames(read_any_performance(source, tell))


def heard(listen: str | None, seconds: float | None) -> Iterator[FaceFrame]:
    """Frames of the iPhone app, as they come."""
    receiver = open_receiver(listen)
    try:
        yield from frames_of(receiver.packets(seconds or float("inf"), PATIENCE_S))
    finally:
        receiver.close()


def looked_at(
    source: Path, rig: Path | None, seconds: float | None, device: str | None, page: bool = False
) -> Iterator[FaceFrame]:
    """Frames of a camera or a take, tracked as they come."""
    from ..landmarks.detector import FaceLandmarker, require_landmarker
    from ..landmarks.on_rig import landmarks_of
    from ..landmarks.stream import with_landmarks
    from ..tracking.model import tracking_model
    from ..tracking.pipeline import TrackTakeConfig, track_frames
    from ..tracking.tracker_context import NoTimer
    from .live_page import LivePage
    from .track import as_live, open_source, rig_for

    require_landmarker()
    camera = str(source) == CAMERA
    options = CameraOptions(device=device) if seconds is None else CameraOptions(seconds, device)
    take = open_source(source, camera, options, PicturesReading(), None)
    take = take if camera else as_live(take)
    person, landmarks = rig_for(rig)
    model = tracking_model(person, landmarks or landmarks_of(person))
    live = LivePage(take, person) if page else None
    watched = take if live is None else live.take
    seen = with_landmarks(watched, FaceLandmarker("video"), late=True)
    timer = NoTimer() if live is None else live.feed
    results = track_frames(model, take, seen, TrackTakeConfig(live=True), timer)
    if live is None:
        yield from tracked_frames(results, person, take.rate)
        return
    with live.open():
        results = live.watched(results)
        yield from tracked_frames(results, person, take.rate)


def tracked_frames(results, rig, rate: float) -> Iterator[FaceFrame]:
    """What the tracker says, frame by frame; those before a face is found are left out."""
    import numpy as np

    from ..rig import Performance
    from ..tracking.pipeline import T_WORLD_CAMERA

    for number, result in enumerate(results):
        if not result.tracked:
            continue
        pose = T_WORLD_CAMERA @ result.T_camera_face
        weights = result.weights[None]
        tracked = np.ones(1, bool)
        one = Performance(rig, weights, pose[None], rate, tracked)
        [frame] = face_frames(one, centre=False)
        yield FaceFrame(number, rate, frame.row, frame.rotation)


class Counter:
    """Says what is sent where once the first frame has left, and counts."""

    def __init__(self, to: Receivers):
        self._names = [f"{name} {place}" for name, place in (("VMC", to.vmc), ("Live Link", to.livelink)) if place]
        self.frames = 0

    def __call__(self, sent: int) -> None:
        if self.frames == 0:
            tell(f"sending to {' and '.join(self._names)}; Ctrl-C ends")
        self.frames = sent


def tell_sent(sent: Sent, senders: list[UdpSender]) -> None:
    """The line that ends a stream."""
    line = f"sent {sent.frames} frames"
    if sent.skipped:
        line += f", left out {sent.skipped} whose time had passed"
    print(line)
    for sender in senders:
        if sender.lost:
            print(f"mien: {sender.lost} packets could not be sent: {sender.fault}", file=sys.stderr)
