"""C3D marker takes."""

import re
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ....errors import BadInput
from ....units import known_unit
from ..marker_file import RawTake
from .frames import find_layout, read_frames
from .parameters import C3dHeader, C3dParameters, read_header

_COMPUTED_LISTS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS", "MODELED_MARKERS")
"""Parameters of POINT in which Vicon lists the points that are no markers."""
_COMPUTED = re.compile(r"(angles?|forces?|moments?|powers?|scalars?|centreofmass|centerofmass|grf)$", re.IGNORECASE)
_LABEL_LIST = re.compile(r"LABELS(\d*)")


def read_c3d(path: Path) -> RawTake:
    """The marker points of a C3D file of any processor, integers or floats, in the file's unit.

    Left out: points that the file lists as angles, forces, moments, powers, scalars or modelled markers, and points
    whose names end so. A negative residual is a gap. Where POINT:Y_SCREEN (and X_SCREEN) name the lab's axes, positions
    are turned so that +Y is up and +X the screen's right. Damaged parameters are left out; points without a label are
    unlabelled.

    Raises:
        BadInput: not a C3D file, cut off, or without points.
    """
    data = path.read_bytes()
    header, parameters = read_header(path, data)
    layout = find_layout(path, len(data), header, parameters)
    if layout.points == 0:
        raise BadInput(f"{path}: has no marker points{_what_else(header, parameters)}; export the labelled markers")
    positions = read_frames(data, layout, parameters.processor)
    names = _labels(parameters, layout.points)
    computed = _computed(names, parameters)
    keep = [i for i, name in enumerate(names) if name not in computed]
    turn = _turn_to_y_up(parameters.text("POINT", "X_SCREEN"), parameters.text("POINT", "Y_SCREEN"))
    positions = positions[:, keep]
    unit = parameters.text("POINT", "UNITS")
    return RawTake(
        positions=positions if turn is None else positions @ turn.T,
        labels=tuple(names[i] for i in keep),
        rate=_rate(header, parameters),
        mm=known_unit(unit),
        up_source="unknown" if turn is None else "file",
        warnings=tuple(_warnings(path, len(names), len(computed & set(names)), unit)),
    )


def _warnings(path: Path, points: int, computed: int, unit: str) -> list[str]:
    lines = []
    if computed:
        lines.append(f"{path}: {computed} of {points} points are computed (angles, forces, ...) and were left out")
    if unit and known_unit(unit) is None:
        lines.append(f"{path}: POINT:UNITS is {unit!r}, which is no length; taken as not stated")
    return lines


def _what_else(header: C3dHeader, parameters: C3dParameters) -> str:
    """What a file without points holds."""
    if header.analog or parameters.count("ANALOG", "USED"):
        return ", only analog channels"
    return ", only events" if parameters.count("EVENT", "USED") else ""


def _labels(parameters: C3dParameters, points: int) -> list[str]:
    """LABELS, LABELS2, ...: C3D lists hold 255 names each. "" where there is none."""
    matched = [found for name in parameters.groups.get("POINT", {}) if (found := _LABEL_LIST.fullmatch(name))]
    lists = [found[0] for found in sorted(matched, key=lambda found: int(found[1] or 1))]
    names = [name for key in lists for name in parameters.texts("POINT", key)]
    return (names + [""] * points)[:points]


def _computed(names: list[str], parameters: C3dParameters) -> set[str]:
    listed = {name for group in _COMPUTED_LISTS for name in parameters.texts("POINT", group) if name}
    return listed | {name for name in names if _COMPUTED.search(name)}


def _rate(header: C3dHeader, parameters: C3dParameters) -> float | None:
    stated = (parameters.number("POINT", "RATE") or 0.0, header.rate)
    return next((rate for rate in stated if rate > 0), None)


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
