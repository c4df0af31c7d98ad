"""RGB-D takes from files of any kind, read lazily, and writing the folder form."""

from dataclasses import replace
from pathlib import Path

from ..errors import BadInput
from ..files import existing
from .folder import DEPTH, part_of, read_folder, read_images
from .intrinsics import read_intrinsics, write_intrinsics
from .realsense import read_realsense
from .record3d import read_record3d
from .take import RgbdTake
from .video import read_video
from .write import write_rgbd

VIDEO_SUFFIXES = (".mp4", ".mov", ".avi", ".m4v", ".mkv", ".webm")


def read_rgbd(
    path: str | Path, depth_scale: float | None = None, rate: float | None = None, focal: float | None = None
) -> RgbdTake:
    """Open a take: the RGB-D folder, Record3D `.r3d`, RealSense `.bag`, a video, or a folder of colour images.

    Args:
        depth_scale: units a metre in the folder's depth images, instead of what `take.json` says (1000 by default).
        rate: frames a second, instead of what the take says.
        focal: focal length in pixels, for a video, whose lens nobody knows.

    Raises:
        BadInput: missing, none of these, or damaged.
    """
    path = existing(path)
    for name, value in (("depth-scale", depth_scale), ("rate", rate), ("focal", focal)):
        if value is not None and not 0 < value < float("inf"):
            raise BadInput(f"{path}: --{name} {value:g} cannot be; give a number above 0")
    if path.is_dir():
        take = (
            read_folder(path, depth_scale, rate)
            if any(part_of(path, DEPTH).glob("*.*"))
            else read_images(path, rate, focal)
        )
    elif path.suffix.lower() == ".r3d":
        take = read_record3d(path)
    elif path.suffix.lower() == ".bag":
        take = read_realsense(path)
    elif path.suffix.lower() in VIDEO_SUFFIXES:
        take = read_video(path, focal)
    else:
        raise BadInput(f"{path}: not a take; give an RGB-D folder, .r3d, .bag, or a video ({' '.join(VIDEO_SUFFIXES)})")
    if not take.count:
        raise BadInput(f"{path}: holds no frames")
    return take if rate is None else replace(take, rate=rate)


__all__ = ["RgbdTake", "read_intrinsics", "read_rgbd", "write_intrinsics", "write_rgbd"]
