"""C3D marker takes, through ezc3d."""

import re
from pathlib import Path
from typing import Literal

import ezc3d
import numpy as np
from jaxtyping import Float

from ...clip import Markers
from ...errors import BadInput
from ...files import whole
from ..units import known_unit
from .c3d_check import check_c3d
from .marker_file import RawTake, is_unlabelled, without_subject

Axis = Literal["+X", "-X", "+Y", "-Y", "+Z", "-Z"]

_GROUPS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS", "MODELED_MARKERS")
_COMPUTED = re.compile(r"(angles?|forces?|moments?|powers?|scalars?|centreofmass|centerofmass|grf)$", re.IGNORECASE)


def read_c3d(path: Path) -> RawTake:
    """The labelled marker points of a C3D file, in the file's unit.

    Left out: points that the file lists as angles, forces, moments, powers, scalars or modelled markers, points whose
    names end so, and unlabelled ones. A negative residual is a gap. `subject:` prefixes are dropped. Where
    POINT:Y_SCREEN (and X_SCREEN) name the lab's axes, positions are turned so that +Y is up and +X the screen's right.

    Raises:
        BadInput: not a C3D file, or cut off.
    """
    content = _open(path)
    point = content["parameters"]["POINT"]
    names = _labels(point)
    computed = _computed(names, point)
    keep = [i for i, name in enumerate(names) if not is_unlabelled(name) and name not in computed]
    warnings = []
    if len(keep) < len(names):
        left_out = len(names) - len(keep)
        warnings.append(f"{path}: {left_out} of {len(names)} points are not labelled markers and were left out")
    points = content["data"]["points"][:3].transpose(2, 1, 0).astype(np.float64)
    residual = content["data"]["meta_points"]["residuals"][0].T
    positions = np.where((residual < 0)[:, :, None], np.nan, points)[:, keep]
    turn = _turn_to_y_up(_text(point, "X_SCREEN"), _text(point, "Y_SCREEN"))
    unit = _text(point, "UNITS")
    if unit and known_unit(unit) is None:
        warnings.append(f"{path}: POINT:UNITS is {unit!r}, which is no length; taken as not stated")
    return RawTake(
        positions=positions if turn is None else positions @ turn.T,
        labels=tuple(without_subject([names[i] for i in keep])),
        rate=_rate(content),
        mm=known_unit(unit),
        up_source="unknown" if turn is None else "file",
        warnings=tuple(warnings),
    )


def write_c3d(path: str | Path, markers: Markers, up: Axis | None = None) -> None:
    """Write a take as C3D: millimetres, float32, gaps with residual -1. Notes are not written.

    `up` says which axis of the positions points up and is stored as POINT:Y_SCREEN; None leaves it unsaid, and a reader
    has to find it from the face.

    Raises:
        BadInput: the folder does not exist.
    """
    seen = markers.seen
    points = np.ones((4, len(markers.labels), len(seen)))
    points[:3] = np.where(seen[:, :, None], markers.positions, 0.0).transpose(2, 1, 0)
    content = ezc3d.c3d()
    point = content["parameters"]["POINT"]
    point["RATE"]["value"] = [markers.rate]
    point["LABELS"]["value"] = list(markers.labels)
    point["UNITS"]["value"] = ["mm"]
    if up is not None:
        content.add_parameter("POINT", "X_SCREEN", ["+X" if up[1] != "X" else "+Y"])
        content.add_parameter("POINT", "Y_SCREEN", [up])
    content["data"]["points"] = points
    content["data"]["meta_points"]["residuals"] = np.where(seen, 0.0, -1.0).T[None]
    with whole(path) as temporary:
        content.write(str(temporary))


def _open(path: Path) -> ezc3d.c3d:
    """Of a file that is cut off among its frames, ezc3d gives those that are left and says nothing: hence the count."""
    head = check_c3d(path)
    try:
        content = ezc3d.c3d(str(path))
    except (OSError, ValueError, RuntimeError, LookupError, MemoryError) as error:
        raise BadInput(f"{path}: not a readable C3D file ({error}); export it again") from error
    _, points, frames = content["data"]["points"].shape
    if frames < head.frames and points:
        raise BadInput(f"{path}: cut off: its header promises {head.frames} frames, {frames} are there; copy it again")
    return content


def _labels(point) -> list[str]:
    """LABELS, LABELS2, ...: C3D lists hold 255 names each."""
    lists = ["LABELS", *sorted((k for k in point if re.fullmatch(r"LABELS\d+", k)), key=lambda k: int(k[6:]))]
    names = [str(name).strip() for key in lists if key in point for name in point[key]["value"]]
    used = int(_first(point, "USED", float(len(names))))
    return (names + [""] * used)[:used]


def _computed(names: list[str], point) -> set[str]:
    listed = {str(value).strip() for group in _GROUPS if group in point for value in point[group]["value"]}
    return listed | {name for name in names if _COMPUTED.search(name)}


def _rate(content: ezc3d.c3d) -> float | None:
    stated = (_first(content["parameters"]["POINT"], "RATE", 0.0), content["header"]["points"]["frame_rate"])
    return next((float(rate) for rate in stated if rate > 0), None)


def _first(point, key: str, default: float) -> float:
    values = point[key]["value"] if key in point else []
    return float(values[0]) if len(values) else default


def _text(point, key: str) -> str:
    values = point[key]["value"] if key in point else []
    return str(values[0]).strip() if len(values) else ""


def _turn_to_y_up(x_screen: str, y_screen: str) -> Float[np.ndarray, "3 3"] | None:
    """Rotation from the lab's axes to +Y up; rows are the screen's right, up and toward the viewer. None: not said."""
    up = _axis(y_screen)
    if up is None:
        return None
    right = _axis(x_screen)
    if right is None or right @ up != 0:
        right = np.array([0.0, 1.0, 0.0]) if abs(up[0]) else np.array([1.0, 0.0, 0.0])
    return np.stack([right, up, np.cross(right, up)])


def _axis(name: str) -> np.ndarray | None:
    found = re.fullmatch(r"([+-]?)([XYZ])", name.strip().upper())
    if found is None:
        return None
    return np.eye(3)["XYZ".index(found[2])] * (-1.0 if found[1] == "-" else 1.0)
