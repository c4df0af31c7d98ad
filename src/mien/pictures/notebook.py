"""`mien.show`: a picture of anything that can be looked at, which a notebook displays."""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image

from ..clip import Markers
from ..depth import RGBDFrame
from ..mesh import Mesh, Scan
from ..one_line import one_line
from ..rig import Performance, Rig
from .colormap import colors_of
from .sheet import contact_sheet
from .show import Shot, performance_frames, scan_picture, shapes_sheet
from .video import write_png

SIZE = 480
"""Pixels a side of a single picture."""

CELL = 240
"""Pixels a side of a picture on a contact sheet."""

FRAMES = 8
"""Pictures of a performance."""

SHAPES = 11
"""Shapes of a rig that are shown, after its neutral face."""

DOT = 3
"""Radius of a marker, pixels."""

PARTS = ("performance", "scan_rig", "rig", "mesh", "scan", "color")
"""What is shown of a result: the first of these that it has."""


@dataclass(frozen=True)
class Picture:
    """A picture that a notebook shows by itself."""

    image: UInt8[np.ndarray, "h w c"]
    """sRGB."""

    def __repr__(self) -> str:
        return one_line(self, f"{self.image.shape[1]} x {self.image.shape[0]} pixels")

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        Image.fromarray(self.image).save(buffer, format="png")
        return buffer.getvalue()

    def save(self, path: str | Path) -> None:
        """Write it (.png); whole or not at all."""
        write_png(path, self.image)


def show(thing: Any) -> Picture:
    """A picture of a Mesh, Scan, Rig, Performance, Markers, RGBDFrame or image, or of what a result holds of these.

    Raises:
        TypeError: it is nothing of the kind.
    """
    match thing:
        case Picture():
            return thing
        case Mesh():
            return show(Scan(thing))
        case Scan():
            return Picture(scan_picture(thing, Shot(size=SIZE)))
        case Rig():
            return Picture(shapes_sheet(thing, Shot(size=CELL), SHAPES))
        case Performance():
            return Picture(moments(thing))
        case Markers():
            return Picture(dots(thing))
        case np.ndarray():
            return Picture(as_image(thing))
        case RGBDFrame(color=None):
            return show(thing.depth)
    for name in PARTS:
        if getattr(thing, name, None) is not None:
            return show(getattr(thing, name))
    raise TypeError(f"show: a {type(thing).__name__} has no picture")


def moments(performance: Performance) -> UInt8[np.ndarray, "h w 3"]:
    """Frames of a performance, evenly spaced, with their times."""
    evenly = np.linspace(0, len(performance) - 1, min(FRAMES, len(performance)))
    frames = evenly.round().astype(int).tolist()
    images = list(performance_frames(performance, frames, Shot(size=CELL)))
    return contact_sheet(images, [f"{frame / performance.rate:.2f} s" for frame in frames])


def dots(markers: Markers) -> UInt8[np.ndarray, "h w 3"]:
    """The frame that shows most markers, seen along the direction in which the cloud is thinnest."""
    fullest = int(markers.seen.sum(axis=1).argmax())
    points = markers.positions[fullest][markers.seen[fullest]]
    canvas = np.full((SIZE, SIZE, 3), 255, np.uint8)
    for x, y in _flat(points):
        canvas[max(y - DOT, 0) : y + DOT + 1, max(x - DOT, 0) : x + DOT + 1] = 40
    return canvas


def _flat(points: Float[np.ndarray, "k 3"]) -> np.ndarray:
    """(k, 2) pixels: the two principal axes, filling nine tenths of the picture."""
    if not len(points):
        return np.zeros((0, 2), int)
    centred = points - points.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2]
    flat = centred @ axes[:2].T
    largest = max(float(np.abs(flat).max()), 1e-9)
    return np.round(SIZE / 2 + 0.45 * SIZE * flat / largest).astype(int)


def as_image(values: np.ndarray) -> UInt8[np.ndarray, "h w c"]:
    """An image as it is; one channel of numbers (a depth image, a map) in colours from its least to its greatest.

    Raises:
        TypeError: an array of another shape.
    """
    if values.ndim == 3 and values.shape[2] in (3, 4):
        whole = values if values.dtype == np.uint8 else np.round(255 * np.clip(values, 0, 1))
        return whole.astype(np.uint8)
    if values.ndim != 2:
        raise TypeError(f"show: expected an image (h, w) or (h, w, 3 or 4), got {values.shape}")
    known = np.where(np.isfinite(values) & (values != 0), values, np.nan).astype(float)
    low, high = (np.nanmin(known), np.nanmax(known)) if np.isfinite(known).any() else (0.0, 1.0)
    colors = colors_of(known, (low, max(high, low + 1e-9)))
    return np.round(255 * colors).astype(np.uint8)
