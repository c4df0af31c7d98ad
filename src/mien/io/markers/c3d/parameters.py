"""Header block and parameter section of a C3D file, read out of any bytes.

Layout after the C3D user guide (https://www.c3d.org): blocks of 512 bytes; a header block; a section that chains group
records (negative numbers) and parameter records (the positive number of their group).
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....errors import BadInput
from .numbers import DEC, INTEL, MIPS, floats, one_float, words

BLOCK = 512
"""Bytes; places in a C3D file are counted in blocks, from 1."""

MAGIC = 0x50
"""Second byte of every C3D file."""

LARGEST_WORD = 0xFFFF
"""What a 16-bit count holds at most; programs store it where the true count is larger."""

_PROCESSORS = (INTEL, DEC, MIPS)
_SECTION_HEAD = 4
"""Bytes ahead of the first record: two of no use, the number of blocks, the processor."""
_LARGEST_VALUE = 1 << 22
"""Bytes of one parameter's value at most; what claims more is damaged."""

Value = np.ndarray | list[str]


@dataclass(frozen=True)
class C3dHeader:
    """The header block."""

    points: int
    """Points a frame."""
    analog: int
    """Analog values a frame, all channels and samples."""
    first_frame: int
    last_frame: int
    scale: float
    """Length of one integer step; negative: the file stores floats."""
    data_block: int
    """Block of the first frame."""
    rate: float
    """Frames a second; 0 where not stated."""

    @property
    def frames(self) -> int | None:
        """None where the header cannot say: frames count from 1, and 0 is what writers leave that do not fill it in."""
        count = self.last_frame - self.first_frame + 1
        return count if count > 0 and 0 < self.last_frame < LARGEST_WORD else None


@dataclass(frozen=True)
class C3dParameters:
    """The parameter section."""

    processor: int
    groups: dict[str, dict[str, Value]]
    """Values by group and name, both in capitals; numbers flat, strings stripped."""
    end: int
    """Byte behind the section."""

    def has(self, group: str, name: str) -> bool:
        """Is this parameter there?"""
        return name in self.groups.get(group, {})

    def number(self, group: str, name: str) -> float | None:
        """The first number; None where there is none or it is not finite."""
        values = self.groups.get(group, {}).get(name, [])
        if len(values) == 0 or isinstance(values[0], str) or not np.isfinite(values[0]):
            return None
        return float(values[0])

    def count(self, group: str, name: str) -> int | None:
        """The first number as a whole number from 0 on; 16-bit integers are taken as unsigned."""
        value = self.number(group, name)
        if value is None:
            return None
        return int(value) + (LARGEST_WORD + 1 if value < 0 else 0)

    def texts(self, group: str, name: str) -> list[str]:
        """The strings; none where the parameter is missing or holds numbers."""
        values = self.groups.get(group, {}).get(name, [])
        return values if isinstance(values, list) else []

    def text(self, group: str, name: str) -> str:
        """The first string, or ""."""
        return next(iter(self.texts(group, name)), "")


def read_header(path: Path, data: bytes) -> tuple[C3dHeader, C3dParameters]:
    """Header and parameters of a C3D file's bytes. Parameters that lead nowhere are left out.

    Raises:
        BadInput: not C3D, or shorter than one block.
    """
    if len(data) < BLOCK or data[1] != MAGIC:
        raise BadInput(f"{path}: not a C3D file; give the .c3d that the capture program exported")
    start = (max(data[0], 2) - 1) * BLOCK
    section = data[start : start + _SECTION_HEAD]
    processor = _processor(section)
    parameters = _parameters(data, start, processor)
    counts = words(data[2:20], processor) & LARGEST_WORD
    header = C3dHeader(
        points=int(counts[0]),
        analog=int(counts[1]),
        first_frame=int(counts[2]),
        last_frame=int(counts[3]),
        scale=one_float(data[12:16], processor),
        data_block=int(counts[7]),
        rate=one_float(data[20:24], processor),
    )
    return header, parameters


def _processor(section: bytes) -> int:
    """The stated processor; some programs store 1, 2, 3; Intel where none is stated."""
    stated = section[3] if len(section) == _SECTION_HEAD else 0
    known = {code: code for code in _PROCESSORS} | dict(zip((1, 2, 3), _PROCESSORS, strict=True))
    return known.get(stated, INTEL)


def _parameters(data: bytes, start: int, processor: int) -> C3dParameters:
    """Follow the chain to its end, whatever number of blocks the section claims."""
    names: dict[int, str] = {}
    values: dict[tuple[int, str], Value] = {}
    at = start + _SECTION_HEAD
    while at is not None and at < len(data):
        record = _record(data, at, processor)
        if record is None:
            break
        number, name, value, following = record
        if number < 0:
            names.setdefault(-number, name)
        elif value is not None:
            values.setdefault((number, name), value)
        at = following
    groups: dict[str, dict[str, Value]] = {name: {} for name in names.values()}
    for (number, name), value in values.items():
        if number in names:
            groups[names[number]].setdefault(name, value)
    claimed = data[start + 2] if start + 2 < len(data) else 0
    return C3dParameters(processor, groups, start + claimed * BLOCK)


def _record(data: bytes, at: int, processor: int) -> tuple[int, str, Value | None, int | None] | None:
    """(group number, name, value, place of the next record) of the record at `at`; None where there is none.

    The next record stands where the record says; where that is behind it or outside, right behind its description.
    """
    if at + 2 > len(data):
        return None
    length, number = struct.unpack_from("bb", data, at)
    name_end = at + 2 + abs(length)
    if length == 0 or number == 0 or name_end + 2 > len(data):
        return None
    name = _text(data[at + 2 : name_end]).upper()
    step = int(words(data[name_end : name_end + 2], processor)[0])
    body = name_end + 2
    value, own_end = (None, body) if number < 0 else _value(data, body, processor)
    if own_end is not None and own_end < len(data):
        own_end += 1 + data[own_end]
    if step == 0:
        return number, name, value, own_end if _looks_like_record(data, own_end) else None
    following = name_end + step
    inside = following >= body and following <= len(data)
    return number, name, value, following if inside else own_end


def _looks_like_record(data: bytes, at: int | None) -> bool:
    """Does a record with a plain name stand here? Some programs store the end mark too early."""
    if at is None or at + 2 > len(data):
        return False
    length, number = struct.unpack_from("bb", data, at)
    name = data[at + 2 : at + 2 + abs(length)]
    plain = name.isascii() and name.replace(b"_", b"").isalnum()
    return length != 0 and number != 0 and plain


def _value(data: bytes, at: int, processor: int) -> tuple[Value | None, int | None]:
    """(value, byte behind it) of a parameter; (None, None) where it is damaged."""
    if at + 2 > len(data):
        return None, None
    kind, dimensions = struct.unpack_from("bB", data, at)
    sizes = list(data[at + 2 : at + 2 + dimensions])
    start = at + 2 + dimensions
    size = abs(kind) * int(np.prod(np.array(sizes, dtype=np.float64))) if dimensions < 8 else _LARGEST_VALUE + 1
    if kind not in (-1, 1, 2, 4) or size > _LARGEST_VALUE or start + size > len(data):
        return None, None
    raw = data[start : start + size]
    return _decoded(raw, kind, sizes, processor), start + size


def _decoded(raw: bytes, kind: int, sizes: list[int], processor: int) -> Value:
    if kind == -1:
        width = sizes[0] if sizes else 1
        count = len(raw) // width if width else 0
        return [_text(raw[i * width : (i + 1) * width]) for i in range(count)]
    if kind == 1:
        return np.frombuffer(raw, np.int8).astype(np.int64)
    return words(raw, processor) if kind == 2 else floats(raw, processor)


def _text(raw: bytes) -> str:
    raw = raw.split(b"\0")[0]
    try:
        return raw.decode("utf-8").strip()
    except UnicodeDecodeError:
        return raw.decode("latin-1").strip()
