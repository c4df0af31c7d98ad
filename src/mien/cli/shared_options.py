"""Options that several verbs have, as groups: how a take is read, and the pages beside an output."""

import sys
from dataclasses import dataclass
from pathlib import Path

from ..rgbd import RgbdTake, read_rgbd
from .options import refuse_unused
from .outputs import beside


@dataclass(frozen=True)
class TakeReading:
    """How a marker take is read."""

    units: str | None = None
    """mm, cm, m, in, or millimetres in one unit as a number; needed only where the file's own claim is wrong."""
    rate: float | None = None
    """Frames a second, where the file does not say."""


@dataclass(frozen=True)
class NamedPages:
    """Pages that will be written."""

    picture: Path
    report: Path

    @property
    def outputs(self) -> dict[str, Path | None]:
        """As `check_outputs` takes them."""
        return {"a picture": self.picture, "a page": self.report}


@dataclass(frozen=True)
class Pages:
    """Pages beside an animated face."""

    picture: Path | None = None
    """Write a contact sheet (.png); by default beside the output."""
    report: Path | None = None
    """Write the report (.html); by default beside the output."""

    def named_by(self, output: Path) -> NamedPages:
        """Both, by default with the output's name."""
        return NamedPages(beside(output, self.picture, ".png"), beside(output, self.report, ".html"))


PIXELS_MM = 0.05, 10.0
"""Least and most millimetres a pixel of a scan's map; finer ones fill the memory."""
CAMERA, LIVE_LINK = "live", "livelink"
"""Words that stand for this computer's camera, and for the Live Link Face app, in place of a take."""


@dataclass(frozen=True)
class CameraOptions:
    """How this computer's camera is used."""

    seconds: float = 10.0
    """How long to look through a camera, or to listen to the app."""
    device: str | None = None
    """Which camera, as FFmpeg calls it (/dev/video0); without it the first."""


@dataclass(frozen=True)
class PicturesReading:
    """How an RGB-D take or a video is read."""

    depth_scale: float | None = None
    """Units a metre in a folder's depth images, instead of what its take.json says."""
    focal: float | None = None
    """Focal length of a video's lens, pixels; without it 60 degrees are assumed across the longer side."""


def read_pictures(path: Path, reading: PicturesReading, rate: float | None = None) -> RgbdTake:
    """The take, opened; its notes told.

    Raises:
        BadInput: it is none, or an option was given that it does not heed.
    """
    take = read_rgbd(path, reading.depth_scale, rate, reading.focal)
    if not take.has_depth or not path.is_dir():
        refuse_unused("for a take that is no folder with depth", "reading.depth_scale")
    if take.camera.fx != reading.focal:
        refuse_unused("for a take that knows its camera", "reading.focal")
    tell_notes(take)
    return take


def tell_notes(take: RgbdTake) -> None:
    """What was guessed or mended when a take was opened, a line each."""
    for note in take.notes:
        print(f"mien: {note}", file=sys.stderr)
