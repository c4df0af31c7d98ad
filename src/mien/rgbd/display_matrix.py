"""Video frames the way up that their file asks for: phones film sideways and say so in a display matrix."""

from typing import Any

import av
import numpy as np
from jaxtyping import Int, UInt8

_ONE = 1 << 16
"""Fixed point of the matrix' first two columns."""


def shown_upright(frame: "av.VideoFrame") -> UInt8[np.ndarray, "h w 3"]:
    """A decoded frame as sRGB, turned and mirrored as its display matrix says."""
    return turned(frame.to_ndarray(format="rgb24"), matrix_of(frame))


def matrix_of(frame: "av.VideoFrame") -> Int[np.ndarray, "2 2"]:
    """M with (x, y)_shown = (x, y)_stored M, rounded to quarter turns and mirrorings; x to the right, y down."""
    entries: Any = frame.side_data
    for data in entries:
        if "DISPLAYMATRIX" in str(data.type):
            matrix = np.frombuffer(bytes(data), "<i4")[:9].reshape(3, 3)[:2, :2] / _ONE
            rounded = np.round(matrix / max(np.abs(matrix).max(), 1e-9)).astype(int)
            if abs(round(float(np.linalg.det(rounded)))) == 1:
                return rounded
    return np.eye(2, dtype=int)


def turned(image: UInt8[np.ndarray, "h w 3"], matrix: Int[np.ndarray, "2 2"]) -> UInt8[np.ndarray, "a b 3"]:
    """An image under such a matrix."""
    if matrix[0, 0] == 0:
        image, matrix = image.transpose(1, 0, 2), matrix[::-1]
    return np.ascontiguousarray(image[:: matrix[1, 1], :: matrix[0, 0]])
