"""`mien doctor`: what is installed, what is missing, and how fast this machine is."""

import os
import platform
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import count, islice
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .. import __version__
from ..errors import BadInput
from ..extras import EXTRAS
from ..rgbd import RgbdTake
from ..rig import Rig
from .options import verb

TEST_S = 2.0
"""How long the speed test tracks."""
_WARM_FRAMES = 5
"""Frames before the clock starts: loops are compiled, the detector is loaded."""
_SIDE = 480
"""Pixels a side of the picture that is tracked."""
RATES = (60, 30, 15)
"""Frames a second that cameras have."""


@verb
def doctor(*, speed: Annotated[bool, Parameter(negative="--no-speed")] = True) -> None:
    """What is installed, which extras are missing and the line that adds them, cameras, cores, and a speed test.

    Parameters
    ----------
    speed
        Track a face for two seconds, to tell how fast this machine is; --no-speed leaves it out.
    """
    for line in [*machine(), *extras(), *model(), *cameras()]:
        print(line)
    if speed:
        print(speed_line())


def machine() -> list[str]:
    """Versions and cores."""
    version = platform.python_version()
    system = f"{platform.system()} {platform.machine()}"
    cores = os.cpu_count() or 1
    return [f"mien {__version__}, Python {version}, {system}, {cores} cores"]


def extras() -> list[str]:
    """A line an extra."""
    lines = []
    for extra, (module, what) in EXTRAS.items():
        if find_spec(module) is None:
            lines.append(f"missing  {extra}: {what}; pip install 'mien[{extra}]'")
        else:
            lines.append(f"there    {extra}: {what}")
    return lines


def model() -> list[str]:
    """The landmark model."""
    from ..landmarks.model_file import model_path

    try:
        path = model_path()
    except BadInput as error:
        return [f"missing  landmark model: {error}"]
    return [f"there    landmark model: {path}"]


def cameras() -> list[str]:
    """Cameras, where the system lists them as files."""
    if not sys.platform.startswith("linux"):
        return ["cameras: not listed on this system; `mien track live` opens the first"]
    found = sorted(Path("/dev").glob("video*"))
    names = ", ".join(map(str, found))
    return [f"cameras: {names or 'none'}"]


def speed_line() -> str:
    """How long tracking takes a frame, and what that means; or why it was not tried."""
    try:
        took = tracking_seconds()
    except BadInput as error:
        return f"speed: not tried ({error})"
    ms = 1000 * took
    kept = next((rate for rate in RATES if took * rate <= 1), None)
    means = f"live at {kept} frames a second" if kept else "too slow for live tracking; takes are tracked all the same"
    busy = "; other programs keep this machine busy" if is_busy() else ""
    return f"speed: {ms:.0f} ms a frame from colour alone: {means}{busy}"


def is_busy() -> bool:
    """Whether more was running in the last minute than this machine has cores, where the system tells."""
    if not hasattr(os, "getloadavg"):
        return False
    load, *_ = os.getloadavg()
    return load > (os.cpu_count() or 1)


def tracking_seconds() -> float:
    """Seconds a frame of tracking a picture of the bundled face, after the first few.

    Raises:
        BadInput: landmarks are not installed.
    """
    from ..faces.bundled import load_face
    from ..landmarks.detector import FaceLandmarker, require_landmarker
    from ..landmarks.on_rig import bundled_map
    from ..landmarks.stream import with_landmarks
    from ..tracking.model import tracking_model
    from ..tracking.pipeline import track_frames

    require_landmarker()
    rig = load_face().rig
    take = still_take(rig)
    seen = with_landmarks(take, FaceLandmarker("video"))
    model = tracking_model(rig, bundled_map())
    results = track_frames(model, take, seen)
    return seconds_each(results)


def seconds_each(results: Iterator) -> float:
    """Mean time of what comes, after the first few, for as long as the test lasts."""
    for _ in islice(results, _WARM_FRAMES):
        pass
    start = time.perf_counter()
    spent, frames = 0.0, 0
    while frames == 0 or spent < TEST_S:
        next(results)
        frames += 1
        spent = time.perf_counter() - start
    return spent / frames


def still_take(rig: Rig) -> RgbdTake:
    """A film of one picture of the face, endless."""
    from ..depth import RGBDFrame
    from ..mesh import Scan
    from ..pictures.show import Shot, scan_picture
    from ..rgbd.intrinsics import assumed_camera

    scan = Scan(rig.neutral, rig.texture)
    shot = Shot(size=_SIDE)
    picture = scan_picture(scan, shot)
    camera = assumed_camera(_SIDE, _SIDE, None)

    def frames() -> Iterator[RGBDFrame]:
        for number in count():
            yield RGBDFrame(picture, None, number / RATES[1])

    return RgbdTake("speed test", camera, RATES[1], 1, False, frames, guessed_camera=True)
