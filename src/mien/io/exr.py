"""OpenEXR images with named channels, 32-bit or 16-bit float: positions, colours, confidences, map coefficients."""

from pathlib import Path

import numpy as np
import OpenEXR
from jaxtyping import Float32

from ..errors import BadInput
from ..files import existing, whole

MAGIC = b"\x76\x2f\x31\x01"
"""The first bytes of every OpenEXR file."""


def read_exr(path: str | Path) -> dict[str, Float32[np.ndarray, "h w"]]:
    """Every channel of an image by its name, as 32-bit float; NaN stays NaN.

    Raises:
        BadInput: no such file, not OpenEXR, cut off, of several parts, or with channels of several sizes.
    """
    path = existing(path)
    with path.open("rb") as file:
        if file.read(4) != MAGIC:
            raise BadInput(f"{path}: not an OpenEXR file")
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            if len(file.parts) != 1:
                raise BadInput(f"{path}: {len(file.parts)} parts; write one image a file")
            channels = {name: np.array(c.pixels, np.float32) for name, c in file.channels().items()}
    except (RuntimeError, ValueError, TypeError, MemoryError) as error:
        raise BadInput(f"{path}: cannot be read as OpenEXR ({_line(error)}); is the file whole?") from None
    if not channels or len({image.shape for image in channels.values()}) != 1:
        raise BadInput(f"{path}: channels of several sizes, or none; write them at one size")
    return channels


def write_exr(path: str | Path, channels: dict[str, Float32[np.ndarray, "h w"]], half: bool = False) -> None:
    """Write channels of one size by their names, losslessly compressed; `half` keeps 16 bits of each value.

    Raises:
        BadInput: no channels, several sizes, or a folder that does not exist.
    """
    shapes = {image.shape for image in channels.values()}
    if len(shapes) != 1:
        raise BadInput(f"{path}: expected channels of one size, got {sorted(shapes)}")
    kind = np.float16 if half else np.float32
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    pixels = {name: np.ascontiguousarray(image, kind) for name, image in channels.items()}
    with whole(path) as temporary, OpenEXR.File(header, pixels) as file:
        file.write(str(temporary))


def _line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
