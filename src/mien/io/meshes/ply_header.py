"""The header of a PLY file: its elements and their properties, the order of its bytes, the pictures that it names."""

import re
from dataclasses import dataclass
from pathlib import Path

from ...errors import BadInput

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Which some editors put ahead of text."""
_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4",
    "double": "f8", "float64": "f8", "int64": "i8", "uint64": "u8", "long": "i8", "ulong": "u8",
}  # fmt: skip
_ENDS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_END = re.compile(rb"end_header[ \t]*(\r\n|\n|\r|$)")


@dataclass(frozen=True)
class PlyProperty:
    """A value of every row of an element."""

    name: str
    kind: str
    """numpy type of the value, or of a list's items."""
    count: str = ""
    """numpy type of a list's length; "" for a plain value."""


@dataclass
class PlyElement:
    """So many rows of the same properties."""

    name: str
    size: int
    properties: list[PlyProperty]


@dataclass(frozen=True)
class PlyHeader:
    """What a PLY file says of itself."""

    elements: list[PlyElement]
    end: str
    """Byte order as numpy names it; "" for text."""
    body: int
    """Byte at which the rows begin."""
    pictures: list[str]
    """Names of the colour pictures (`comment TextureFile`)."""


def read_ply_header(path: Path, data: bytes) -> PlyHeader:
    """The header, whatever ends its lines.

    Raises:
        BadInput: no PLY, cut off in its header, a line that makes no sense.
    """
    start = len(BYTE_ORDER_MARK) if data.startswith(BYTE_ORDER_MARK) else 0
    stop = _END.search(data)
    if data[start : start + 3].lower() != b"ply" or stop is None:
        raise BadInput(f"{path}: is not a PLY file, or cut off in its header; export it again")
    body = stop.end()
    if stop[1] == b"\r\n" and b"\r\n" not in data[: stop.start()]:
        body -= 1  # lines end in a carriage return, and the first byte of the rows looks like a line feed
    elements, end, pictures = [], "", []
    for line in data[start : stop.start()].decode("latin-1").splitlines():
        words = line.split()
        try:
            if words[:1] == ["format"]:
                end = _ENDS[words[1].lower()]
            elif words[:1] == ["element"]:
                elements.append(PlyElement(words[1], int(words[2]), []))
            elif words[:2] == ["property", "list"]:
                elements[-1].properties.append(PlyProperty(words[4], _TYPES[words[3]], _TYPES[words[2]]))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(PlyProperty(words[2], _TYPES[words[1]]))
            elif [word.lower() for word in words[:2]] == ["comment", "texturefile"]:
                pictures.append(line.split(None, 2)[2].strip())
        except (LookupError, ValueError) as error:
            raise BadInput(f"{path}: has a header line that is no PLY: {line.strip()!r}") from error
    return PlyHeader(elements, end, body, pictures)
