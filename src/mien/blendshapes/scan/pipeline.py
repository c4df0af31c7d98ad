"""One expression held before an RGB-D sensor to one map (Casas et al. 2016, sec. 3)."""

from dataclasses import dataclass, field

from ...landmarks.stream import Landmarker
from ...one_line import count, one_line
from ...progress import SILENT, Progress
from ...rgbd import RgbdTake
from ..cylinder_map import CylinderMap
from .average import coloured, enough, fused, layouts, place_in_head, registered, starts_of
from .colour import ColourConfig
from .frames import FramesConfig, PlacedFrame, frames_with_face, reference_frame
from .fuse import FuseConfig


@dataclass(frozen=True)
class FusionConfig:
    """How a capture becomes a scan."""

    pixel_mm: float = 0.5
    """Side of the map's pixels, mm."""
    passes: int = 2
    """How often all frames are registered to the map so far: first to the reference frame's, then to the average."""
    frames: FramesConfig = field(default_factory=FramesConfig)
    fuse: FuseConfig = field(default_factory=FuseConfig)
    colour: ColourConfig = field(default_factory=ColourConfig)


@dataclass(frozen=True)
class FusedScan:
    """A capture as one map."""

    map: CylinderMap
    used: int
    """Frames that went into it."""
    dropped: int
    """Frames that show the face but could not be registered."""
    deviation_mm: float
    """How far frames are from their average, median over the map, mm."""
    moved_mm: float
    """How far landmarks moved within the head, median over the frames, mm."""

    def __repr__(self) -> str:
        return one_line(self, self.map, f"{count(self.used, 'frames')}, {self.dropped} dropped")


def scan_take(
    take: RgbdTake,
    config: FusionConfig = FusionConfig(),
    landmarker: Landmarker | None = None,
    progress: Progress = SILENT,
) -> FusedScan:
    """A map in face space from the frames of one held expression.

    Raises:
        BadInput: no depth, no face, depth in another unit, or a head whose expression does not hold still.
    """
    seen = frames_with_face(take, landmarker, config.frames, progress)
    reference, T_face_camera = reference_frame(seen, take.name)
    starts, moved = place_in_head(seen, reference, T_face_camera, take.name, config.frames)
    layout, coarse = layouts(config.pixel_mm)
    placed = [PlacedFrame(seen[reference], T_face_camera)]
    at = 0
    for done in range(config.passes):
        progress.update("registering frames", done, config.passes)
        rough = fused(placed, take.camera, coarse, config.fuse)
        placed, at = registered(
            seen=seen,
            starts=starts,
            average=rough,
            layout=coarse,
            camera=take.camera,
            config=config.frames,
            reference=reference,
        )
        starts = starts_of(placed, seen, starts)
    enough(placed, seen, take.name)
    average = fused(placed, take.camera, layout, config.fuse)
    map_ = coloured(
        average=average,
        placed=placed,
        reference=at,
        layout=layout,
        take=take,
        config=config.colour,
    )
    progress.update("registering frames", config.passes, config.passes)
    dropped = len(seen) - len(placed)
    return FusedScan(map_, len(placed), dropped, average.deviation_mm, moved)
