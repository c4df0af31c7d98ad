"""A face that is tracked right now, frame by frame to every page that looks on."""

import io
import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image

from ..depth import RGBDFrame
from ..rgbd import RgbdTake
from ..transforms import Transform, quaternions_from_rotations
from .server import Answer, Routes

PICTURE_WIDTH = 480
"""Pixels of the sensor's picture beside the face."""

PICTURE_QUALITY = 70
"""Of its JPEG: about 20 kB a frame."""

WAIT_S = 5.0
"""A page hears at least an empty message so often, so that one that has gone is noticed."""

MOST_RECORDED = 1800
"""Frames that a recording holds: a minute at 30 a second."""


class LiveFeed:
    """What the tracker says, kept for pages; it is the tracker's `StageTimer` too. Pages' words come from threads."""

    def __init__(self, keep: Callable[[list[RGBDFrame]], str]):
        """`keep` writes a recording and says where."""
        self._keep = keep
        self._news = threading.Condition()
        self._message, self._count = b"", 0
        self._spent: dict[str, float] = {}
        self._frame: RGBDFrame | None = None
        self._centre: np.ndarray | None = None
        self._neutral: np.ndarray | None = None
        self._last: np.ndarray | None = None
        self._recorded: list[RGBDFrame] | None = None

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time that is spent inside belongs to a stage."""
        began = time.perf_counter()
        yield
        self._spent[name] = self._spent.get(name, 0.0) + time.perf_counter() - began

    def watched(self, take: RgbdTake) -> RgbdTake:
        """The take, its frames seen as they pass."""
        return replace(take, frames=lambda: self._passing(take))

    def _passing(self, take: RgbdTake) -> Iterator[RGBDFrame]:
        for frame in take:
            self._frame = frame
            recorded = self._recorded
            if recorded is not None and len(recorded) < MOST_RECORDED:
                recorded.append(frame)
            yield frame

    def calibrated(self, weights: Float[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
        """Weights with the neutral that was held taken off: it becomes 0, and 1 stays 1."""
        if self._neutral is None:
            return weights
        return np.clip((weights - self._neutral) / np.maximum(1 - self._neutral, 1e-3), 0, None)

    def show(self, weights: Float[np.ndarray, " k"], T_world_face: Transform, tracked: bool) -> None:
        """A frame's outcome to all pages."""
        self._last = weights
        if self._centre is None and tracked:
            self._centre = T_world_face.translation
        centre = np.zeros(3) if self._centre is None else self._centre
        place = T_world_face.translation - centre
        turn = quaternions_from_rotations(T_world_face.rotation[None])[0]
        told = {
            "tracked": tracked,
            "ms": {name: round(1e3 * seconds, 1) for name, seconds in self._spent.items()},
            "recording": None if self._recorded is None else len(self._recorded),
        }
        numbers = np.concatenate([self.calibrated(weights), place, turn])
        picture = b"" if self._frame is None or self._frame.color is None else small_jpeg(self._frame.color)
        self._spent = {}
        with self._news:
            self._message = pack_message(told, numbers, picture)
            self._count += 1
            self._news.notify_all()

    def add_routes(self, routes: Routes) -> None:
        """What the page can ask of it."""
        routes.stream["/live"] = self._send
        routes.post["/calibrate"] = self._calibrate
        routes.post["/record"] = self._record

    def _send(self, write: Callable[[bytes], None], asked: Mapping[str, str]) -> None:
        seen = 0
        while True:
            with self._news:
                self._news.wait_for(lambda seen=seen: self._count != seen, WAIT_S)
                seen, message = self._count, self._message
            write(message or pack_message({}, np.zeros(0), b""))

    def _calibrate(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        self._neutral = None if body == b"off" or self._last is None else np.clip(self._last, 0, 0.9)
        return Answer(b"calibrated" if self._neutral is not None else b"as tracked", "text/plain")

    def _record(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        recorded, self._recorded = self._recorded, None
        if recorded is None:
            self._recorded = []
            return Answer(b"recording", "text/plain")
        return Answer((self._keep(recorded) if recorded else "nothing was recorded").encode(), "text/plain")


def pack_message(told: Mapping[str, object], numbers: Float[np.ndarray, " k"], picture: bytes) -> bytes:
    """One message: lengths of all, of the JSON and of the numbers (4 bytes each, little-endian); those; a JPEG."""
    text = json.dumps(told).encode()
    text += b" " * (-len(text) % 4)
    values = numbers.astype("<f4").tobytes()
    sizes = (len(text) + len(values) + len(picture), len(text), len(values))
    return b"".join([*(size.to_bytes(4, "little") for size in sizes), text, values, picture])


def small_jpeg(image: UInt8[np.ndarray, "h w 3"]) -> bytes:
    """A picture no wider than `PICTURE_WIDTH`."""
    picture = Image.fromarray(image)
    step = max(1, picture.width // PICTURE_WIDTH)
    buffer = io.BytesIO()
    picture.reduce(step).save(buffer, format="jpeg", quality=PICTURE_QUALITY)
    return buffer.getvalue()
