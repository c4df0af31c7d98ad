"""Landmarks worked out in a thread of their own, while the tracker works on the frame before."""

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from typing import Protocol, runtime_checkable

import numpy as np

from .._kernels._spread import pool_of_generator
from ..depth import RGBDFrame
from ..errors import BadInput
from .detector import Landmarks2D


@runtime_checkable
class Landmarker(Protocol):
    """Anything that finds 478 landmarks in a picture, `mien.landmarks.detector.FaceLandmarker` above all."""

    def detect(self, image: np.ndarray, time: float | None = None) -> Landmarks2D | None:
        """The face in an RGB image, or None."""
        ...


def with_landmarks(
    frames: Iterable[RGBDFrame], landmarker: Landmarker, ahead: int = 2, late: bool = False
) -> Iterator[tuple[RGBDFrame, Landmarks2D | None]]:
    """Each frame with its landmarks, worked out in another thread.

    Args:
        ahead: frames that the thread may be in front; a recorded take can wait for its landmarks.
        late: give each frame the landmarks of the frame before, as a live source must: they are worked out while that
            one is tracked, and a frame waits only where they take longer still. The first frame then has none.
    """
    with pool_of_generator(1) as pool:
        yield from (_late if late else _waiting)(iter(frames), landmarker, pool, ahead)


def _waiting(walk, landmarker, pool, ahead):
    """In step: frames wait for their landmarks. A walk that breaks off still gives the frames before the break."""
    pending: deque[tuple[RGBDFrame, Future]] = deque()
    broken = None
    while True:
        try:
            frame = next(walk, None)
        except BadInput as error:
            frame, broken = None, error
        if frame is None:
            break
        pending.append((frame, pool.submit(_look, landmarker, frame)))
        if len(pending) > ahead:
            first, future = pending.popleft()
            yield first, future.result()
    for first, future in pending:
        yield first, future.result()
    if broken is not None:
        raise broken


def _late(walk, landmarker, pool, _ahead):
    """Each frame comes with what was found in the one before, as soon as that is known."""
    before: Future | None = None
    for frame in walk:
        found = None if before is None else before.result()
        before = pool.submit(_look, landmarker, frame)
        yield frame, found


def _look(landmarker: Landmarker, frame: RGBDFrame) -> Landmarks2D | None:
    return None if frame.color is None else landmarker.detect(frame.color, frame.time)
