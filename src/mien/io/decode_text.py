"""Text files in the encodings that programs write: UTF-8 and UTF-16 with or without their marks, else Latin-1."""

import codecs
from pathlib import Path

from ..errors import BadInput

_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_HEAD = 4096
"""Bytes that are looked at."""


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
    zeros = [head[i::2].count(0) for i in (0, 1)]
    if sum(zeros) > 0.4 * len(head) and min(zeros) < 0.1 * max(zeros):
        return data.decode("utf-16-be" if zeros[0] > zeros[1] else "utf-16-le", "replace")
    if b"\0" in head:
        raise BadInput(f"{path}: is binary, not a text table; does its suffix fit its content?")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")
