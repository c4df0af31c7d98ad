"""Colour pictures that go with meshes."""

from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from ...errors import BadInput
from ...files import existing, whole


def read_image(path: str | Path) -> UInt8[np.ndarray, "h w 3"]:
    """A PNG, JPEG or other picture as sRGB, without alpha.

    Raises:
        BadInput: missing, no picture, cut off.
    """
    path = existing(path)
    try:
        with Image.open(path) as image:
            return np.asarray(image.convert("RGB"))
    except (OSError, ValueError, SyntaxError) as error:
        raise BadInput(f"{path}: is no picture that can be read ({error}); give PNG or JPEG") from error


def write_image(path: str | Path, image: UInt8[np.ndarray, "h w 3"]) -> None:
    """Write a picture in the format of its suffix.

    Raises:
        BadInput: the folder does not exist.
    """
    with whole(path) as temporary:
        Image.fromarray(image).save(temporary)
