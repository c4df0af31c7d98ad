"""Pictures side by side, with words on them."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import UInt8
from PIL import Image, ImageDraw

from ..errors import BadInput
from .scale import INK, PAPER, font, scale_bar


def label(
    image: UInt8[np.ndarray, "h w 3"], text: str, size: int | None = None
) -> UInt8[np.ndarray, "h w 3"]:
    """`text` in the lower left corner of a copy of `image`, with a dark edge so that it reads on anything."""
    height = image.shape[0]
    size = size or max(11, height // 28)
    page = Image.fromarray(image)
    place = (round(size * 0.7), height - round(size * 0.6))
    draw = ImageDraw.Draw(page)
    draw.text(place, text, font=font(size), fill=INK, anchor="ls", stroke_width=max(1, size // 12), stroke_fill=PAPER)
    return np.asarray(page)


def hstack(images: Sequence[UInt8[np.ndarray, "h _ 3"]], gap: int = 4) -> UInt8[np.ndarray, "h w 3"]:
    """Pictures of one height in a row.

    Raises:
        BadInput: no picture, or heights that differ.
    """
    heights = {image.shape[0] for image in images}
    if len(heights) != 1:
        raise BadInput(f"pictures in a row: expected one height, got {sorted(heights)}")
    between = np.full((heights.pop(), gap, 3), PAPER, dtype=np.uint8)
    row = [part for image in images for part in (between, image)][1:]
    return np.concatenate(row, axis=1)


def contact_sheet(
    images: Sequence[UInt8[np.ndarray, "h w 3"]],
    captions: Sequence[str] | None = None,
    columns: int | None = None,
    gap: int = 4,
) -> UInt8[np.ndarray, "sh sw 3"]:
    """Pictures of one size in rows of `columns` (about square where None), each with its caption in it.

    Raises:
        BadInput: no picture, sizes that differ, or another number of captions.
    """
    sizes = {image.shape for image in images}
    if len(sizes) != 1:
        raise BadInput(f"contact sheet: expected pictures of one size, got {sorted(sizes) or 'none'}")
    if captions is not None and len(captions) != len(images):
        raise BadInput(f"contact sheet: expected {len(images)} captions, one a picture, got {len(captions)}")
    height, width, _ = sizes.pop()
    columns = columns or int(np.ceil(np.sqrt(len(images))))
    columns = min(columns, len(images))
    rows = -(-len(images) // columns)
    sheet = np.full((rows * (height + gap) - gap, columns * (width + gap) - gap, 3), PAPER, dtype=np.uint8)
    for place, image in enumerate(images):
        row, column = divmod(place, columns)
        cell = image if captions is None else label(image, captions[place])
        sheet[row * (height + gap) :, column * (width + gap) :][:height, :width] = cell
    return sheet


def with_scale(
    image: UInt8[np.ndarray, "h w 3"], limits: tuple[float, float], unit: str = "mm", colormap: str = "heat"
) -> UInt8[np.ndarray, "h w2 3"]:
    """A heat map with its scale standing on the right."""
    height = image.shape[0]
    return hstack([image, scale_bar(max(64, height // 8), height, limits, unit, colormap, upright=True)], gap=0)
