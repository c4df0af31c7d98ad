"""A look at a C3D file's bytes before ezc3d takes it apart: on one cut off early, ezc3d waits for ever or crashes.

Layout after the C3D user guide (https://www.c3d.org): blocks of 512 bytes; a header block, then the parameter section,
a chain of groups and parameters, then frames.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import BadInput

BLOCK = 512
_LITTLE, _DEC, _BIG = 84, 85, 86
_FEWEST_PARAMETERS = {("POINT", "USED"), ("POINT", "LABELS")}


@dataclass(frozen=True)
class C3dHead:
    """What the header block promises."""

    points: int
    """Points a frame."""
    frames: int
    """0 where the header cannot say (from frame 65535 on, or big-endian files)."""


def check_c3d(path: Path) -> C3dHead:
    """Look at header and parameters.

    Raises:
        BadInput: not C3D; cut off or damaged in its header or parameters.
    """
    with path.open("rb") as file:
        head = file.read(BLOCK)
        if len(head) < BLOCK or head[1] != 0x50 or head[0] == 0:
            raise BadInput(f"{path}: not a C3D file; give the .c3d that the capture program exported")
        file.seek((head[0] - 1) * BLOCK)
        start = file.read(4)
        if len(start) < 4 or start[3] not in (_LITTLE, _DEC, _BIG):
            raise BadInput(f"{path}: not a C3D file, or cut off at once; export it again")
        section = start + file.read(start[2] * BLOCK - 4)
    end = ">" if start[3] == _BIG else "<"
    try:
        found = _walk(section, end)
        used = int.from_bytes(found["POINT", "USED"], "big" if end == ">" else "little")
    except (struct.error, LookupError, ValueError) as error:
        raise BadInput(f"{path}: is cut off or damaged in its parameters; copy or export it again") from error
    points, first, last = struct.unpack_from(end + "H2xHH", head, 2)
    if used != points:
        raise BadInput(f"{path}: is damaged: {points} points in its header, {used} in POINT:USED; export it again")
    return C3dHead(points, last - first + 1 if last != 0xFFFF else 0)


def _walk(section: bytes, end: str) -> dict[tuple[str, str], bytes]:
    """Raw values by group and parameter; struct.error or LookupError where the chain leads nowhere."""
    groups: dict[int, str] = {}
    values: dict[tuple[int, str], bytes] = {}
    at = 4
    while section[at] != 0:
        length, group = struct.unpack_from("bb", section, at)
        name_end = at + 2 + abs(length)
        name = section[at + 2 : name_end].decode("latin-1").upper()
        (step,) = struct.unpack_from(end + "h", section, name_end)
        following = name_end + step if step else len(section)
        if following <= name_end or following > len(section) or group == 0:
            raise IndexError("the next parameter lies outside")
        if group < 0:
            groups[-group] = name
        else:
            values[group, name] = _value(section[name_end + 2 : following])
        if step == 0:
            break
        at = following
    named = {(groups[group], name): value for (group, name), value in values.items()}
    if not named.keys() >= _FEWEST_PARAMETERS:
        raise LookupError("parameters are missing")
    return named


def _value(record: bytes) -> bytes:
    """The bytes of a parameter's value; its description must follow whole."""
    kind, dimensions = struct.unpack_from("bB", record)
    if kind not in (-1, 1, 2, 4):
        raise ValueError(f"a parameter of type {kind}")
    sizes = struct.unpack_from(f"{dimensions}B", record, 2)
    start = 2 + dimensions
    stop = start + abs(kind) * int(np.prod(sizes, dtype=np.int64))
    if stop + 1 > len(record) or stop + 1 + record[stop] > len(record):
        raise IndexError("a value is cut off")
    return record[start:stop]
