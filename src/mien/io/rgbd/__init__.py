"""RGB-D takes from files of any kind, read lazily, and writing the folder form."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from PIL import Image

from ...camera import Camera
from ...depth import RGBDFrame
from ...errors import BadInput
from ...files import existing, whole
from ...progress import SILENT, Progress

VIDEO_SUFFIXES = (".mp4", ".mov", ".avi", ".mkv", ".webm")


@dataclass(frozen=True)
class RgbdTake:
    """A take whose frames are read one by one, each time anew that it is walked through."""

    name: str
    """What messages call it."""
    camera: Camera
    """Of colour, to which depth is registered."""
    rate: float
    """Frames a second."""
    count: int
    """Frames that the take should have."""
    has_depth: bool
    frames: Callable[[], Iterator[RGBDFrame]]
    """A new walk through the frames. A frame that cannot be read raises BadInput; those before it are good."""
    guessed_camera: bool = False
    """The camera is an assumption: a video does not say what lens took it."""
    depth_scale: float | None = None
    """Units a metre that the folder's depth images were read with; None where the file itself is sure."""

    def __iter__(self) -> Iterator[RGBDFrame]:
        return self.frames()

    def __len__(self) -> int:
        return self.count


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
    if path.is_dir():
        from .folder import read_folder, read_images

        take = read_folder(path, depth_scale, rate) if (path / "depth").is_dir() else read_images(path, rate, focal)
    elif path.suffix.lower() == ".r3d":
        from .record3d import read_record3d

        take = read_record3d(path)
    elif path.suffix.lower() == ".bag":
        from .realsense import read_realsense

        take = read_realsense(path)
    elif path.suffix.lower() in VIDEO_SUFFIXES:
        from .video import read_video

        take = read_video(path, focal)
    else:
        raise BadInput(f"{path}: not a take; give an RGB-D folder, .r3d, .bag, or a video ({' '.join(VIDEO_SUFFIXES)})")
    if not take.count:
        raise BadInput(f"{path}: holds no frames")
    return take if rate is None else replace(take, rate=rate)


def write_rgbd(
    folder: str | Path,
    take: RgbdTake,
    depth_scale: float = 1000.0,
    color: Literal["png", "jpg"] = "png",
    progress: Progress = SILENT,
) -> None:
    """Write the folder form: color/, depth/ (16-bit PNG), camera_intrinsic.json, take.json, timestamps.csv.

    PNG keeps colour exactly; JPEG (quality 95) is a fifth of the size. Frames of an older take there are removed.

    Raises:
        BadInput: the folder's parent does not exist, or a depth does not fit in 16 bits at this scale.
    """
    folder = Path(folder)
    if not folder.parent.is_dir():
        raise BadInput(f"{folder}: the folder {folder.parent} does not exist; create it first")
    for part in (folder / "color", folder / "depth"):
        part.mkdir(parents=True, exist_ok=True)
        for old in part.glob("[0-9]*.*"):
            old.unlink()
    write_intrinsics(folder / "camera_intrinsic.json", take.camera)
    (folder / "take.json").write_text(json.dumps({"depth_scale": depth_scale, "fps": take.rate}))
    times = []
    for i, frame in enumerate(take):
        if frame.color is not None:
            file = folder / "color" / f"{i:06d}.{color}"
            Image.fromarray(frame.color).save(file, compress_level=1, quality=95)
        if frame.depth is not None:
            units = np.nan_to_num(frame.depth) * (depth_scale / 1000)
            if units.max(initial=0) > 65535:
                raise BadInput(f"{folder}: depth of {frame.depth.max():.0f} mm does not fit 16 bits; lower depth_scale")
            values = np.round(units).astype(np.uint16)
            Image.fromarray(values).save(folder / "depth" / f"{i:06d}.png", compress_level=1)
        times.append(frame.time)
        progress.update("writing the take", i + 1, take.count)
    with whole(folder / "timestamps.csv") as temporary:
        temporary.write_text("frame,seconds\n" + "".join(f"{i},{t:.6f}\n" for i, t in enumerate(times)))


def write_intrinsics(path: str | Path, camera: Camera) -> None:
    """Write Open3D's PinholeCameraIntrinsic JSON (3 x 3 matrix, column by column)."""
    matrix = [camera.fx, 0, 0, 0, camera.fy, 0, camera.cx, camera.cy, 1]
    with whole(path) as temporary:
        temporary.write_text(
            json.dumps({"width": camera.width, "height": camera.height, "intrinsic_matrix": matrix}, indent=1)
        )


def read_intrinsics(path: str | Path) -> Camera:
    """Read Open3D's PinholeCameraIntrinsic JSON.

    Raises:
        BadInput: missing, or without what it must hold.
    """
    path = Path(path)
    if not path.is_file():
        raise BadInput(f"{path}: the camera's intrinsics are missing; write Open3D's PinholeCameraIntrinsic JSON there")
    try:
        data = json.loads(path.read_text())
        m = [float(value) for value in data["intrinsic_matrix"]]
        camera = Camera(m[0], m[4], m[6], m[7], int(data["width"]), int(data["height"]))
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise BadInput(
            f"{path}: needs width, height and intrinsic_matrix (9 numbers, column by column); {error!r}"
        ) from error
    if not (camera.fx > 0 and camera.fy > 0):
        raise BadInput(f"{path}: focal lengths must be above 0, got {camera.fx} and {camera.fy}")
    return camera


def assumed_camera(width: int, height: int, focal: float | None) -> Camera:
    """A camera for a video: 60 degrees across the longer side unless `focal` (pixels) is given."""
    focal = float(focal or max(width, height) / (2 * np.tan(np.radians(30.0))))
    return Camera(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)
