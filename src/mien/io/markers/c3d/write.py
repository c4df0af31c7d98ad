"""Marker takes out as C3D."""

import struct
from pathlib import Path
from typing import Literal

import numpy as np

from ....clip import Markers
from ....errors import BadInput
from ....files import whole
from .numbers import INTEL
from .parameters import BLOCK, LARGEST_WORD, MAGIC

Axis = Literal["+X", "-X", "+Y", "-Y", "+Z", "-Z"]

_LONGEST_LIST = 255
"""Names in one list at most: sizes are one byte."""
_LONGEST_RECORD = 32000
"""Bytes of a parameter's value: the way to the next record is a signed 16-bit number."""
_FIRST_PARAMETER_BLOCK = 2
_MOST_PARAMETER_BLOCKS = 255
_STORED_AS_FLOATS = -1.0
"""POINT:SCALE: negative, and of length one."""
_GAP = -1.0
"""Residual of a point that was not seen."""

Parameter = tuple[str, bytes]


def write_c3d(path: str | Path, markers: Markers, up: Axis | None = None) -> None:
    """Write a take as C3D: Intel floats, millimetres, gaps with residual -1. Notes are not written.

    `up` says which axis of the positions points up and is stored as POINT:Y_SCREEN; None leaves it unsaid, and a reader
    has to find it from the face. From 65,535 frames on, the header's count is full: TRIAL:ACTUAL_START_FIELD and
    ACTUAL_END_FIELD and POINT:LONG_FRAMES hold the true one.

    Raises:
        BadInput: the folder does not exist, or there are more points than C3D can hold.
    """
    frames, points = markers.positions.shape[:2]
    if points > LARGEST_WORD:
        raise BadInput(f"{path}: {points} points; C3D holds {LARGEST_WORD}")
    section = _section(markers, up, data_block=0)
    data_block = _FIRST_PARAMETER_BLOCK + len(section) // BLOCK
    section = _section(markers, up, data_block)
    if len(section) > _MOST_PARAMETER_BLOCKS * BLOCK:
        raise BadInput(f"{path}: the names of {points} markers are too long for C3D; shorten them")
    last = min(frames, LARGEST_WORD)
    header = struct.pack("<BBHHHHHfHHf", _FIRST_PARAMETER_BLOCK, MAGIC, points, 0, 1, last, 0,
                         _STORED_AS_FLOATS, data_block, 0, float(markers.rate))  # fmt: skip
    values = np.zeros((frames, points, 4), "<f4")
    seen = markers.seen
    values[:, :, :3] = np.where(seen[:, :, None], markers.positions, 0.0)
    values[:, :, 3] = np.where(seen, 0.0, _GAP)
    with whole(path) as temporary:
        temporary.write_bytes(_to_blocks(header) + section + _to_blocks(values.tobytes()))


def _section(markers: Markers, up: Axis | None, data_block: int) -> bytes:
    """The parameter section in whole blocks."""
    records = b"".join(
        _group(number, name, parameters)
        for number, (name, parameters) in enumerate(_groups(markers, up, data_block).items(), start=1)
    )
    end = b"\0\0"
    blocks = -(-(4 + len(records) + len(end)) // BLOCK)
    head = struct.pack("<BBBB", 1, MAGIC, min(blocks, _MOST_PARAMETER_BLOCKS), INTEL)
    return _to_blocks(head + records + end)


def _groups(markers: Markers, up: Axis | None, data_block: int) -> dict[str, list[Parameter]]:
    frames, points = markers.positions.shape[:2]
    point = [
        _words("USED", points),
        _floats("SCALE", _STORED_AS_FLOATS),
        _floats("RATE", float(markers.rate)),
        _words("DATA_START", data_block),
        _words("FRAMES", min(frames, LARGEST_WORD)),
        _strings("UNITS", ["mm"]),
        *_label_lists(markers.labels),
    ]
    if up is not None:
        point += [_strings("X_SCREEN", ["+X" if up[1] != "X" else "+Y"]), _strings("Y_SCREEN", [up])]
    analog = [_words("USED", 0), _floats("GEN_SCALE", 1.0), _floats("RATE", float(markers.rate))]
    groups = {"POINT": point, "ANALOG": analog, "FORCE_PLATFORM": [_words("USED", 0)]}
    if frames >= LARGEST_WORD:
        point.append(_floats("LONG_FRAMES", float(frames)))
        low, high = frames % (LARGEST_WORD + 1), frames // (LARGEST_WORD + 1)
        groups["TRIAL"] = [_words("ACTUAL_START_FIELD", 1, 0), _words("ACTUAL_END_FIELD", low, high)]
    return groups


def _label_lists(labels: tuple[str, ...]) -> list[Parameter]:
    """LABELS, LABELS2, ...: as many names in each as it holds."""
    width = max((len(label.encode()) for label in labels), default=1)
    together = max(1, min(_LONGEST_LIST, _LONGEST_RECORD // max(width, 1)))
    lists = [labels[i : i + together] for i in range(0, len(labels), together)] or [()]
    return [_strings("LABELS" if i == 0 else f"LABELS{i + 1}", list(part)) for i, part in enumerate(lists)]


def _group(number: int, name: str, parameters: list[Parameter]) -> bytes:
    return _record(-number, name, b"") + b"".join(_record(number, key, value) for key, value in parameters)


def _record(number: int, name: str, value: bytes) -> bytes:
    """A group or a parameter with an empty description."""
    description = b"\0"
    step = 2 + len(value) + len(description)
    return struct.pack("<bb", len(name), number) + name.encode() + struct.pack("<h", step) + value + description


def _words(name: str, *values: int) -> Parameter:
    sizes = b"\0" if len(values) == 1 else struct.pack("BB", 1, len(values))
    return name, b"\2" + sizes + struct.pack(f"<{len(values)}H", *values)


def _floats(name: str, value: float) -> Parameter:
    return name, b"\4\0" + struct.pack("<f", value)


def _strings(name: str, texts: list[str]) -> Parameter:
    raw = [text.encode()[:_LONGEST_LIST] for text in texts]
    width = max((len(text) for text in raw), default=0)
    body = b"".join(text.ljust(width) for text in raw)
    return name, struct.pack("<bBBB", -1, 2, width, len(raw)) + body


def _to_blocks(data: bytes) -> bytes:
    """Filled with zeros to whole blocks."""
    return data + bytes(-len(data) % BLOCK)
