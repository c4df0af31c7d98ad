"""The one binary that a page loads: a header that says what there is, and the arrays behind it.

Four bytes tell the header's length (little-endian), then JSON, then the arrays, each at a multiple of `ALIGN` bytes
after the header's end. An array stands in the JSON as `{"at": byte, "type": "f4", "shape": [...]}`, a picture as
`{"at": byte, "bytes": n, "mime": "image/png"}`.
"""

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from PIL import Image

ALIGN = 8
"""Bytes: no array begins elsewhere, so that the page reads it where it lies."""

KINDS = {"f4": np.float32, "i2": np.int16, "u4": np.uint32, "u2": np.uint16, "u1": np.uint8}
"""Types of arrays that a page knows, little-endian."""

PNG_PIXELS = 512 * 512
"""Pictures of more pixels go as JPEG, a tenth of the size."""

JPEG_QUALITY = 92
"""Of large textures: no seam shows at it."""


class SceneWriter:
    """Arrays and pictures gathered; `file` joins them."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def array(self, values: Any, kind: str) -> dict[str, Any]:
        """Keep an array as one of `KINDS`; what stands for it in the header."""
        typed = np.ascontiguousarray(values, np.dtype(KINDS[kind]).newbyteorder("<"))
        return {"at": self._keep(typed.tobytes()), "type": kind, "shape": list(typed.shape)}

    def picture(self, image: np.ndarray) -> dict[str, Any]:
        """Keep an 8-bit picture (h, w, 3 or 4)."""
        small = image.shape[0] * image.shape[1] <= PNG_PIXELS or image.shape[2] == 4
        kind = "png" if small else "jpeg"
        buffer = io.BytesIO()
        Image.fromarray(image).save(buffer, format=kind, **({} if small else {"quality": JPEG_QUALITY}))
        data = buffer.getvalue()
        return {"at": self._keep(data), "bytes": len(data), "mime": f"image/{kind}"}

    def file(self, header: Mapping[str, Any]) -> bytes:
        """The whole file."""
        text = json.dumps(header, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-(4 + len(text)) % ALIGN)
        return b"".join([len(text).to_bytes(4, "little"), text, *self._parts])

    def _keep(self, data: bytes) -> int:
        at = self._size
        padded = data + bytes(-len(data) % ALIGN)
        self._parts.append(padded)
        self._size += len(padded)
        return at


def read_scene(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Header and arrays' bytes of a scene file."""
    length = int.from_bytes(data[:4], "little")
    return json.loads(data[4 : 4 + length]), data[4 + length :]


def read_array(body: bytes, told: Mapping[str, Any]) -> np.ndarray:
    """An array by what stands for it in the header."""
    shape: Sequence[int] = told["shape"]
    kind = np.dtype(KINDS[told["type"]]).newbyteorder("<")
    return np.frombuffer(body, kind, int(np.prod(shape)), told["at"]).reshape(shape)
