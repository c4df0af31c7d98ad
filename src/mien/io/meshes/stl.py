"""STL, binary and text: triangles alone. Corners at one place become one vertex, in first-met order."""

import re
from pathlib import Path

import numpy as np

from ...errors import BadInput
from ...files import existing
from ...mesh import Mesh
from .obj import BYTE_ORDER_MARK
from .polygons import weld

_HEAD = 2000
"""Bytes by which text is told from binary."""
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path: str | Path) -> tuple[Mesh, None]:
    """The mesh of an STL file in the file's unit.

    Raises:
        BadInput: missing, not STL, cut off.
    """
    path = existing(path)
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) >= 84 + 50 * count and not _is_text(data):
        corners = np.frombuffer(data, _TRIANGLE, count, 84)["corners"].reshape(-1, 3)
    elif _is_text(data):
        corners = _text_corners(path, data)
    elif len(data) >= 84:
        need = 84 + 50 * count
        raise BadInput(f"{path}: is no STL, or cut off: {count} triangles need {need} bytes, it has {len(data)}")
    else:
        raise BadInput(f"{path}: is not an STL file; export it again")
    with np.errstate(invalid="ignore"):  # not-a-numbers that signal: what they lead to is refused where surfaces are
        corners = corners.astype(np.float64)
    if len(corners) == 0:
        return Mesh(corners, np.zeros((0, 3), np.int64)), None
    place = weld(corners)
    first = np.unique(place, return_index=True)[1]
    return Mesh(corners[first], place.reshape(-1, 3)), None


def _is_text(data: bytes) -> bool:
    """Binary files may start with "solid" too, but have no line that says facet."""
    head = data[:_HEAD].removeprefix(BYTE_ORDER_MARK).lstrip().lower()
    return head.startswith(b"solid") and (b"facet" in head or b"endsolid" in head)


def _text_corners(path: Path, data: bytes) -> np.ndarray:
    data = data.lower()
    found = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data)
    if len(found) % 3 or b"endsolid" not in data:
        raise BadInput(f"{path}: is cut off: its text ends inside a triangle or without endsolid; export it again")
    try:
        return np.array(found, dtype="S").reshape(-1, 3).astype(np.float64)
    except ValueError as error:
        raise BadInput(f"{path}: is damaged ({error}); export it again") from error
