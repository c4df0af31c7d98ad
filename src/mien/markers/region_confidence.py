"""How well each part of the face is told: markers left out by turns, a region at a time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..mesh import Attachment
from ..rig import Rig
from .between_markers import lid_mask
from .left_out import LeftOutError, missed, without_jitter

PARTS = ("forehead", "eye", "cheek")
"""Regions of the face that have a left and a right; `mouth` and `chin` have none."""
ON = 0.5
"""A marker is in a region whose mask is above this where it sits."""
STILL_MM = 0.3
"""What moves less, three times the jitter of a marker, says nothing of how well a motion is told."""


@dataclass(frozen=True)
class RegionConfidence:
    """A region of the face and how well its markers are told by those of the others and its own others."""

    name: str
    markers: int
    """How many sit there; 0: not seen."""
    off_mm: float = np.nan
    """rms distance of the left-out markers there, without jitter; NaN where none was tried."""
    motion_mm: float = np.nan
    """... and how far they move about their mean places."""

    @property
    def share(self) -> float:
        """The share of the motion that is missed; NaN where nothing is seen or nothing moves."""
        return missed(self.off_mm, self.motion_mm) if self.motion_mm >= STILL_MM else np.nan

    @property
    def told(self) -> str:
        """For a table: the share, or why there is none."""
        if not self.markers:
            return "not seen"
        if not np.isfinite(self.off_mm):
            return "not tried"
        return f"{self.share:.0%}" if np.isfinite(self.share) else "hardly moves"


def region_confidence(
    rig: Rig, attachment: Attachment, regions: Mapping[str, Float[np.ndarray, " n"]], left_out: LeftOutError
) -> tuple[RegionConfidence, ...]:
    """Foreheads, eyes, lids, cheeks, mouth and chin, each with what is known of it.

    Args:
        attachment: where the markers sit on `rig`.
        regions: masks of the rig's vertices by name, as the bundled face has them.
    """
    D = attachment.matrix(rig.neutral)
    lids = lid_mask(rig)
    names = [f"{part}_{side}" for part in PARTS for side in ("left", "right")] + ["mouth", "chin"]
    masks = {name: regions[name] * (1 - lids) for name in names} | {"lids": lids}
    return tuple(_confidence(name, D @ mask > ON, left_out) for name, mask in masks.items())


def _confidence(name: str, inside: np.ndarray, left_out: LeftOutError) -> RegionConfidence:
    label, count = name.replace("_", " "), int(inside.sum())
    off, moved = left_out.marker_mm, left_out.marker_motion_mm
    if not count or off is None or moved is None or not np.isfinite(off[:, inside]).any():
        return RegionConfidence(label, count)
    off_mm, motion_mm = (without_jitter(x[:, inside], left_out.jitter_mm) for x in (off, moved))
    return RegionConfidence(label, count, off_mm, motion_mm)


def regions_line(found: tuple[RegionConfidence, ...]) -> str:
    """One line: what is missed of each region's motion, and which no marker sees; empty where nothing was tried."""
    tried = [region for region in found if np.isfinite(region.off_mm)]
    if not tried:
        return ""
    told = ", ".join(f"{region.name} {region.told}" for region in tried)
    unseen = ", ".join(region.name for region in found if not region.markers)
    return f"error of markers left out, of a frozen face's: {told}" + (f"; no marker sees: {unseen}" if unseen else "")
