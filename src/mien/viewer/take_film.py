"""The pictures of an RGB-D take, or of a film that browsers do not play, as a film for the page."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from ..errors import BadInput
from ..pictures import write_mp4
from ..rgbd import VIDEO_SUFFIXES, RgbdTake, read_rgbd
from ..rgbd.folder import DEPTH, part_of
from .studio_scene import Film

WIDEST = 640
"""Pixels: the page shows films small, beside the face."""
PLAYED = (".mp4", ".webm", ".mov", ".m4v")
"""Films that a browser plays as they are."""
RECORDED = (".r3d", ".bag", *(suffix for suffix in VIDEO_SUFFIXES if suffix not in PLAYED))
"""Takes that are made a film first."""


def has_film(path: Path) -> bool:
    """Whether a file or folder is shown as a film."""
    if path.is_dir():
        return any(part_of(path, DEPTH).glob("*.*"))
    return path.suffix.lower() in (*PLAYED, *RECORDED)


def film_of(path: Path) -> Film:
    """The file itself where a browser plays it; else the take's pictures, as a film in a folder that goes at the end.

    Its camera is the take's; a video's is assumed as `mien track` assumes it.

    Raises:
        BadInput: what `read_rgbd` raises.
    """
    if path.suffix.lower() in PLAYED:
        try:
            return Film(path.name, path, read_rgbd(path).camera)
        except BadInput:  # a browser may play it all the same
            return Film(path.name, path)
    take = read_rgbd(path)
    made = Path(_scratch().name) / f"{len(list(Path(_scratch().name).iterdir()))}.mp4"
    write_mp4(made, _pictures(take), take.rate)
    return Film(path.name, made, take.camera)


def _pictures(take: RgbdTake) -> Iterator[UInt8[np.ndarray, "h w 3"]]:
    """One a frame, small; a frame without colour holds the last one."""
    shown = np.zeros((0, 0, 3), np.uint8)
    for frame in take:
        if frame.color is not None:
            height, width = frame.color.shape[:2]
            share = min(1.0, WIDEST / width)
            shown = np.asarray(Image.fromarray(frame.color).resize((round(width * share), round(height * share))))
        if shown.size:
            yield shown


@cache
def _scratch() -> TemporaryDirectory:
    return TemporaryDirectory(prefix="mien-film-")
