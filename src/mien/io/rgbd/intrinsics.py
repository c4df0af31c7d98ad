"""The colour camera of a take: Open3D's PinholeCameraIntrinsic JSON, or an assumption."""

import json
from pathlib import Path

import numpy as np

from ...camera import Camera
from ...errors import BadInput
from ...files import whole


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
