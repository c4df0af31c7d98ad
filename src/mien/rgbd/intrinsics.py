"""The colour camera of a take: Open3D's PinholeCameraIntrinsic JSON, or an assumption."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..camera import Camera
from ..errors import BadInput
from ..files import whole


def write_intrinsics(path: str | Path, camera: Camera) -> None:
    """Write Open3D's PinholeCameraIntrinsic JSON (3 x 3 matrix, column by column)."""
    with whole(path) as temporary:
        temporary.write_text(json.dumps(intrinsics_of(camera), indent=1))


def intrinsics_of(camera: Camera) -> dict[str, Any]:
    """What Open3D's PinholeCameraIntrinsic JSON says of a camera."""
    matrix = [camera.fx, 0, 0, 0, camera.fy, 0, camera.cx, camera.cy, 1]
    return {"width": camera.width, "height": camera.height, "intrinsic_matrix": matrix}


def read_intrinsics(path: str | Path, size: tuple[int, int] | None = None) -> Camera:
    """Read Open3D's PinholeCameraIntrinsic JSON; `size` (width, height) stands in where the file names none.

    Also understood: the matrix row by row or as three lists, and `fx fy cx cy` (or `ppx ppy`) by name.

    Raises:
        BadInput: missing, or without what it must hold.
    """
    path = Path(path)
    if not path.is_file():
        raise BadInput(f"{path}: the camera's intrinsics are missing; write Open3D's PinholeCameraIntrinsic JSON there")
    try:
        data = json.loads(path.read_text("utf-8-sig"))
        data = data.get("intrinsics", data)
        width, height = size if size and "width" not in data else (int(data["width"]), int(data["height"]))
        camera = Camera(*_focal_and_centre(data), width, height)
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, OverflowError) as error:
        raise BadInput(
            f"{path}: needs width, height and intrinsic_matrix (9 numbers, column by column); {error!r}"
        ) from error
    if not (camera.fx > 0 and camera.fy > 0):
        raise BadInput(f"{path}: focal lengths must be above 0, got {camera.fx} and {camera.fy}")
    return camera


def matrix_values(matrix: list) -> tuple[float, float, float, float]:
    """fx, fy, cx, cy of nine numbers, flat or in three lists, row by row or column by column.

    Raises:
        ValueError: not nine numbers.
    """
    m = np.array(matrix, dtype=float)
    if m.size != 9 or not np.isfinite(m).all():
        raise ValueError(f"expected 9 numbers, got {m.size}")
    m = m.ravel()
    by_rows = not m[[6, 7]].any() and bool(m[[2, 5]].any())
    cx, cy = m[[2, 5]] if by_rows else m[[6, 7]]
    return float(m[0]), float(m[4]), float(cx), float(cy)


def _focal_and_centre(data: dict) -> tuple[float, float, float, float]:
    for key in ("intrinsic_matrix", "camera_matrix", "K", "k"):
        if key in data:
            value = data[key]
            return matrix_values(value["data"] if isinstance(value, dict) else value)
    centre = ("cx", "cy") if "cx" in data else ("ppx", "ppy")
    fx, fy, cx, cy = (float(data[key]) for key in ("fx", "fy", *centre))
    return fx, fy, cx, cy


def assumed_camera(width: int, height: int, focal: float | None) -> Camera:
    """A camera for a video: 60 degrees across the longer side unless `focal` (pixels) is given."""
    focal = float(focal or max(width, height) / (2 * np.tan(np.radians(30.0))))
    return Camera(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)
