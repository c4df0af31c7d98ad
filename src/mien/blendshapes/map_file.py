"""Maps on disk: OpenEXR with channels X Y Z (mm, face space), R G B (sRGB, 0..1) and confidence."""

from pathlib import Path

import numpy as np

from ..errors import BadInput
from ..io.exr import read_exr, write_exr
from .cylinder_map import CylinderLayout, CylinderMap

POSITION, COLOUR, CONFIDENCE = ("X", "Y", "Z"), ("R", "G", "B"), "confidence"
OFF_PIXELS = 0.6
"""Points of a map lie within so many pixels of their place on the cylinder, median."""


def write_map(path: str | Path, map_: CylinderMap) -> None:
    """Write a map, 32-bit float, NaN where there is no surface (Casas et al. 2016, sec. 4.1).

    Raises:
        BadInput: the folder does not exist.
    """
    channels = {name: map_.positions[..., i] for i, name in enumerate(POSITION)}
    channels |= {name: map_.colors[..., i] for i, name in enumerate(COLOUR)}
    channels[CONFIDENCE] = map_.confidence
    write_exr(path, {name: image.astype(np.float32) for name, image in channels.items()})


def read_map(path: str | Path) -> CylinderMap:
    """Read what `write_map` wrote.

    Raises:
        BadInput: not OpenEXR, other channels, a size or places that no layout has.
    """
    channels = read_exr(path)
    wanted = (*POSITION, *COLOUR, CONFIDENCE)
    missing = [name for name in wanted if name not in channels]
    if missing:
        raise BadInput(f"{path}: has no channel {', '.join(missing)}; a map has {' '.join(wanted)}")
    positions = np.stack([channels[name] for name in POSITION], -1)
    try:
        layout = CylinderLayout.of_shape(*positions.shape[:2])
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    colors = np.stack([channels[name] for name in COLOUR], -1)
    map_ = CylinderMap(layout, positions, colors, channels[CONFIDENCE], Path(path).stem)
    _check_places(path, map_)
    return map_


def _check_places(path: str | Path, map_: CylinderMap) -> None:
    rows, columns = np.nonzero(map_.known)
    if not len(rows):
        raise BadInput(f"{path}: the map is empty")
    places = map_.layout.pixels(map_.positions[rows, columns].astype(np.float64))
    off = np.median(np.abs(places - np.stack([columns, rows], 1)).max(1))
    if off > OFF_PIXELS:
        raise BadInput(f"{path}: its points are not laid out on our cylinder; give it as a mesh (.ply, .obj) instead")
