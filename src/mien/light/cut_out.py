"""The part of the pictures that shows what is lit: nothing beside it is decoded."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from .decode_sinusoids import DecodeConfig
from .light_rig import RigView
from .patterns import PatternSet

MARGIN_PX = 16
"""Kept round what is lit, so that windows and flows have something to stand on."""


@dataclass(frozen=True)
class Box:
    """A cut-out of a picture, pixels; ends are exclusive."""

    top: int
    left: int
    bottom: int
    right: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """Rows and columns."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


@dataclass(frozen=True)
class CutOut:
    """One camera's pictures, straightened and cut out, and the camera that takes such pictures."""

    images: Float[np.ndarray, "slots h w"]
    view: RigView
    box: Box


def lit_cutout(
    images: Float[np.ndarray, "slots h w"], view: RigView, patterns: PatternSet, config: DecodeConfig = DecodeConfig()
) -> CutOut:
    """The smallest upright part that holds all that the full-on pattern lights.

    Raises:
        BadInput: it lights nothing.
    """
    full = view.straightened(images[patterns.one("full")])
    lit = full > config.darkest
    if not lit.any():
        raise BadInput(f"{view.name}: the full-on pattern lights nothing; mend the exposure, or the slots' order")
    rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
    box = Box(
        max(int(rows[0]) - MARGIN_PX, 0),
        max(int(columns[0]) - MARGIN_PX, 0),
        min(int(rows[-1]) + 1 + MARGIN_PX, len(full)),
        min(int(columns[-1]) + 1 + MARGIN_PX, full.shape[1]),
    )
    y, x = box.slices
    return CutOut(view.straightened(images)[:, y, x], cut_view(view, box), box)


def cut_view(view: RigView, box: Box) -> RigView:
    """The straightened camera whose whole picture is the cut-out."""
    camera = replace(
        view.camera,
        cx=view.camera.cx - box.left,
        cy=view.camera.cy - box.top,
        width=box.right - box.left,
        height=box.bottom - box.top,
    )
    return replace(view, camera=camera, distortion=(0.0,) * 5)
