"""A film that the page draws frame by frame and this side writes as MP4."""

import io
import threading
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PIL import Image

from ...errors import BadInput
from ...pictures import write_mp4
from ..server import Answer

MOST_FRAMES = 20_000
"""Of one film: eleven minutes at 30 a second."""

MOST_NAMES = 1000
"""perf.mp4, perf_2.mp4, ...: names that are tried."""


class FilmOut:
    """Frames as they come from a page, then the file beside what was shown."""

    def __init__(self, beside: Path):
        self._beside = beside
        self._frames: dict[str, list[bytes]] = {}
        self._lock = threading.Lock()

    def add(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        """Keep a frame (JPEG) of the film `film`.

        Raises:
            BadInput: too many.
        """
        with self._lock:
            frames = self._frames.setdefault(asked["film"], [])
            if len(frames) >= MOST_FRAMES:
                raise BadInput(f"film: more than {MOST_FRAMES} frames; draw a part")
            frames.append(body)
        return Answer(b"kept", "text/plain")

    def finish(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        """Write the film `film` at `rate` frames a second.

        Raises:
            BadInput: it has no frames.
        """
        with self._lock:
            frames = self._frames.pop(asked["film"], [])
            if not frames:
                raise BadInput("film: no frames came")
            path = free_name(self._beside.with_suffix(".mp4"))
            images = (np.asarray(Image.open(io.BytesIO(frame)).convert("RGB")) for frame in frames)
            write_mp4(path, images, float(asked["rate"]))
        return Answer(f"{path}: {len(frames)} frames".encode(), "text/plain")


def free_name(path: Path) -> Path:
    """`path`, or the first of `stem_2`, `stem_3`, ... that is free: no film is lost to the next."""
    names = [path, *(path.with_name(f"{path.stem}_{i}{path.suffix}") for i in range(2, MOST_NAMES))]
    return next((name for name in names if not name.exists()), names[-1])
