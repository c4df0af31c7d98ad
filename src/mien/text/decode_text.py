"""Text files in the encodings that programs write: UTF-8 and UTF-16 with or without their marks, else Latin-1."""

import codecs
from pathlib import Path

from ..errors import BadInput

_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_HEAD = 4096
"""Bytes that are looked at."""
_MANY_ZEROS, _FEW_ZEROS = 0.4, 0.1
"""UTF-16 of Western text: this share of all bytes is zero, and next to none of the other bytes of each pair."""


def decode_text(path: Path) -> str:
    """The file as text.

    Raises:
        BadInput: binary.
    """
    data = path.read_bytes()
    return decode_bytes(path, data)


def decode_bytes(path: Path, data: bytes) -> str:
    """`decode_text` of what was read already."""
    for mark, name in _MARKS:
        if data.startswith(mark):
            return data.decode(name, "replace")
    head = data[:_HEAD]
    if encoding := _wide(head):
        return data.decode(encoding, "replace")
    if b"\0" in head:
        raise BadInput(f"{path}: is binary, not text; does its suffix fit its content?")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def is_wide_text(data: bytes) -> bool:
    """Whether the bytes are UTF-16, or hold zeros as no text of one byte a letter does."""
    return data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) or b"\0" in data[:_HEAD]


def _wide(head: bytes) -> str | None:
    """Which UTF-16 it is without a mark: nearly every other byte is zero."""
    zeros = [head[i::2].count(0) for i in (0, 1)]
    if sum(zeros) > _MANY_ZEROS * len(head) and min(zeros) < _FEW_ZEROS * max(zeros):
        return "utf-16-be" if zeros[0] > zeros[1] else "utf-16-le"
    return None
