"""2D face landmarks by MediaPipe (478 points and expression scores), and the same points on the bundled face."""

import os
import sys
import threading
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Literal

import numpy as np
from jaxtyping import Float, Int, UInt8

from ..errors import BadInput
from ..extras import require
from ..mesh import Attachment
from .model_file import model_path

COUNT = 478
"""Points a face: 468 of the face mesh, then 5 of each iris (centre first)."""


LOOPS: dict[str, tuple[int, ...]] = {
    "lips_outer": (61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291, 409, 270, 269, 267, 0, 37, 39, 40, 185),
    "lips_inner": (78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308, 415, 310, 311, 312, 13, 82, 81, 80, 191),
    "eye_left": (263, 249, 390, 373, 374, 380, 381, 382, 362, 398, 384, 385, 386, 387, 388, 466),
    "eye_right": (33, 7, 163, 144, 145, 153, 154, 155, 133, 173, 157, 158, 159, 160, 161, 246),
    "contour": (
        *(10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377),
        *(152, 148, 176, 149, 150, 136, 172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109),
    ),
}
"""Closed curves of landmarks. Eyes run from the outer corner along the lower lid and back along the upper one, lips
from the right corner along the lower lip. The contour is the face's outline as seen: it slides with the view."""
GROUPS: dict[str, tuple[int, ...]] = {
    **LOOPS,
    "brow_left": (276, 283, 282, 295, 285, 336, 296, 334, 293, 300),
    "brow_right": (46, 53, 52, 65, 55, 107, 66, 105, 63, 70),
    "nose_bridge": (168, 6, 197, 195, 5, 4),
    "nose_base": (64, 98, 97, 2, 326, 327, 294),
    "nose_wings": (278, 344, 440, 275, 45, 220, 115, 48, 1, 19, 94),
    "iris_left": (473, 474, 475, 476, 477),
    "iris_right": (468, 469, 470, 471, 472),
}
"""Landmarks by feature; left and right are the subject's."""


@dataclass(frozen=True)
class LandmarkSet:
    """MediaPipe's landmarks fixed on a template."""

    attachment: Attachment
    """All 478, in MediaPipe's order; iris points lie on the eyeballs, all others on the skin."""
    stable: Int[np.ndarray, " k"]
    """Those that stay on the same spot of the skin from view to view: all but the outline and the irises."""
    mirror: Int[np.ndarray, " 478"]
    """The landmark at -x of each."""
    groups: dict[str, Int[np.ndarray, " g"]]
    """`GROUPS` as arrays."""


@cache
def bundled_landmarks() -> LandmarkSet:
    """The landmarks on the bundled face (built by `tools/build_landmarks.py`); symmetric on the neutral face."""
    with (files("mien.faces") / "assets" / "landmarks.npz").open("rb") as file, np.load(file) as data:
        a = dict(data)
    attachment = Attachment(a["faces"].astype(np.int64), a["barycentric"].astype(np.float64))
    groups = {name: np.array(members) for name, members in GROUPS.items()}
    moving = np.concatenate([groups["contour"], groups["iris_left"], groups["iris_right"]])
    return LandmarkSet(attachment, np.setdiff1d(np.arange(COUNT), moving), a["mirror"].astype(np.int64), groups)


@dataclass(frozen=True)
class Landmarks2D:
    """One face in one image."""

    points: Float[np.ndarray, "478 2"]
    """Pixels, x right, y down, centres at integers; may lie outside the image."""
    depth: Float[np.ndarray, " 478"]
    """Pixels, away from the camera, relative to the head's centre; rough."""
    scores: dict[str, float]
    """The 52 ARKit names, 0..1. `tongueOut` is always 0: MediaPipe does not see tongues."""


class FaceLandmarker:
    """MediaPipe's face landmarker, loaded once. Use as a context manager or call `close`.

    In `video` mode frames must come in order; each one starts from where the face was in the last.
    """

    def __init__(self, mode: Literal["image", "video"] = "image", faces: int = 1, confidence: float = 0.5):
        """`faces` = at most so many are found; `confidence` in 0..1 is asked of a detection.

        Raises:
            BadInput: the extra `landmarks`, libGL or the model file is missing.
        """
        vision, options = _mediapipe()
        self._mode = mode
        self._clock_ms = 0
        settings = vision.FaceLandmarkerOptions(
            base_options=options(model_asset_path=str(model_path())),
            running_mode=vision.RunningMode.VIDEO if mode == "video" else vision.RunningMode.IMAGE,
            num_faces=faces,
            min_face_detection_confidence=confidence,
            min_face_presence_confidence=confidence,
            min_tracking_confidence=confidence,
            output_face_blendshapes=True,
        )
        with _quiet():
            self._landmarker = vision.FaceLandmarker.create_from_options(settings)
            self._close = weakref.finalize(self, _close, self._landmarker)
            self.detect_all(np.zeros((64, 64, 3), np.uint8))

    def detect(self, image: UInt8[np.ndarray, "h w 3"], time: float | None = None) -> Landmarks2D | None:
        """The first face in an RGB image, or None. `time` in seconds, only for video: must grow."""
        found = self.detect_all(image, time)
        return found[0] if found else None

    def detect_all(self, image: UInt8[np.ndarray, "h w 3"], time: float | None = None) -> list[Landmarks2D]:
        """Every face that is found in an RGB image, at most as many as were asked for."""
        import mediapipe as mp

        picture = mp.Image(image_format=mp.ImageFormat.SRGB, data=np.ascontiguousarray(image))
        if self._mode == "video":
            now = self._clock_ms + 33 if time is None else round(time * 1000)
            self._clock_ms = max(now, self._clock_ms + 1)
            result = self._landmarker.detect_for_video(picture, self._clock_ms)
        else:
            result = self._landmarker.detect(picture)
        height, width = image.shape[:2]
        return [
            _landmarks(points, scores, width, height)
            for points, scores in zip(result.face_landmarks, result.face_blendshapes, strict=True)
        ]

    def close(self) -> None:
        """Free MediaPipe's threads. Done by itself when the object, or the program, ends."""
        self._close()

    def __enter__(self) -> "FaceLandmarker":
        return self

    def __exit__(self, *_) -> None:
        self.close()


def detect_landmarks(image: UInt8[np.ndarray, "h w 3"]) -> Landmarks2D | None:
    """The first face in an RGB image, or None. One-shot: the detector is kept for the next call.

    Raises:
        BadInput: the extra `landmarks`, libGL or the model file is missing.
    """
    return _shared().detect(image)


def require_landmarker() -> None:
    """Before long work that will look for landmarks.

    Raises:
        BadInput: the extra `landmarks`, libGL or the model file is missing; it says what mends it.
    """
    model_path()
    _mediapipe()


@cache
def _shared() -> FaceLandmarker:
    return FaceLandmarker()


def _close(landmarker) -> None:
    with _quiet():
        try:
            landmarker.close()
        except RuntimeError:  # the interpreter is ending and MediaPipe's own thread has gone; nothing is left to free
            landmarker._handle = None


def _landmarks(points: list, scores: list, width: int, height: int) -> Landmarks2D:
    raw = np.array([(p.x, p.y, p.z) for p in points])
    pixels = raw[:, :2] * [width, height] - 0.5
    named = {s.category_name: float(s.score) for s in scores if s.category_name != "_neutral"}
    return Landmarks2D(pixels, raw[:, 2] * width, {**named, "tongueOut": 0.0})


SYSTEM_LIBRARIES = {
    "libGLES": ("MediaPipe needs the system's libGLESv2 and libEGL", "libgles2 libegl1"),
    "libEGL": ("MediaPipe needs the system's libGLESv2 and libEGL", "libgles2 libegl1"),
    "libGL": ("OpenCV needs the system's libGL.so.1", "libgl1"),
}
"""A library that a message names -> who needs it, and the packages that bring it; in this order."""


def _mediapipe():
    """MediaPipe's vision tasks and BaseOptions, or a line that says what to install."""
    os.environ.setdefault("GLOG_minloglevel", "2")
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "2")
    try:
        tasks = require("mediapipe.tasks.python", "landmarks")
    except BadInput as error:
        for library, (needs, packages) in SYSTEM_LIBRARIES.items():
            if library in str(error):
                raise BadInput(f"landmarks: {needs}; on Debian or Ubuntu: apt install {packages}") from error
        raise
    return tasks.vision, tasks.BaseOptions


_STDERR = threading.RLock()


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence what compiled code writes to stderr while the block runs."""
    with _STDERR:
        sys.stderr.flush()
        kept = os.dup(2)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, 2)
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            os.close(nowhere)
