"""One expression held before an RGB-D sensor to one map (Casas et al. 2016, sec. 3)."""

from dataclasses import dataclass, field

import numpy as np

from ...camera import Camera
from ...errors import BadInput
from ...io.rgbd import RgbdTake
from ...landmarks.stream import Landmarker
from ...mesh import ClosestPoint
from ...one_line import count, one_line
from ...progress import SILENT, Progress
from ...transforms import Transform
from ..cylinder_map import CylinderLayout, CylinderMap, mesh_of_map
from .colour import ColourConfig, blend, chosen_frames, normals_of, photograph
from .frames import (
    FramesConfig,
    PlacedFrame,
    SeenFrame,
    frames_with_face,
    place_by_landmarks,
    place_by_surface,
    reference_frame,
)
from .fuse import FuseConfig, RadiusMap, fuse, radius_of_frame

COARSE_MM = 1.0
"""Side of the pixels of the map that frames are registered to, mm."""
LEAST_FRAMES = 3
"""A scan is made of so many frames at least."""


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
    layout, coarse = CylinderLayout(config.pixel_mm), CylinderLayout(max(COARSE_MM, config.pixel_mm))
    placed, at = [PlacedFrame(seen[reference], T_face_camera)], 0
    for done in range(config.passes):
        progress.update("registering frames", done, config.passes)
        average = fused(placed, take.camera, coarse, config.fuse)
        placed, at = registered(seen, starts, average, coarse, take.camera, config.frames, reference)
        starts = starts_of(placed, seen, starts)
    average = fused(placed, take.camera, layout, config.fuse)
    if len(placed) < min(LEAST_FRAMES, len(seen)):
        raise BadInput(
            f"{take.name}: only {len(placed)} of {len(seen)} frames could be registered; turn the head slowly"
        )
    progress.update("registering frames", config.passes, config.passes)
    map_ = coloured(average, placed, at, layout, take, config.colour)
    return FusedScan(map_, len(placed), len(seen) - len(placed), average.deviation_mm, moved)


def place_in_head(
    seen: list[SeenFrame], reference: int, T_face_camera: Transform, name: str, config: FramesConfig
) -> tuple[list[Transform], float]:
    """T_face_camera of every frame by landmarks, and how still the expression is, mm.

    Raises:
        BadInput: landmarks move within the head: the expression was not held.
    """
    found = [place_by_landmarks(one, seen[reference], T_face_camera) for one in seen]
    moved = float(np.median([away for _, away in found]))
    if moved > config.still_mm:
        raise BadInput(f"{name}: the face moves by {moved:.1f} mm within the head; hold one expression while it turns")
    return [pose for pose, _ in found], moved


def registered(
    seen: list[SeenFrame],
    starts: list[Transform],
    average: RadiusMap,
    layout: CylinderLayout,
    camera: Camera,
    config: FramesConfig,
    reference: int,
) -> tuple[list[PlacedFrame], int]:
    """The frames that fit the average so far, and which of them is the reference."""
    surface = ClosestPoint(mesh_of_map(surface_map(average, layout), step=2).mesh)
    placed, at = [], 0
    for i, (one, start) in enumerate(zip(seen, starts, strict=True)):
        found = place_by_surface(one, start, surface, camera, config)
        if i == reference:
            at = len(placed)
            found = found or PlacedFrame(one, start)
        if found is not None:
            placed.append(found)
    return placed, at


def fused(placed: list[PlacedFrame], camera: Camera, layout: CylinderLayout, config: FuseConfig) -> RadiusMap:
    """The average of the frames as they are placed."""
    drawn = [radius_of_frame(one, camera, layout) for one in placed]
    radii, cosines = (np.stack(parts) for parts in zip(*drawn, strict=True))
    return fuse(radii, cosines, layout, config)


def surface_map(average: RadiusMap, layout: CylinderLayout) -> CylinderMap:
    """The average as a map without colour."""
    positions = layout.points(average.radii.astype(np.float64)).astype(np.float32)
    return CylinderMap(layout, positions, np.full_like(positions, 0.5), average.confidence)


def starts_of(placed: list[PlacedFrame], seen: list[SeenFrame], starts: list[Transform]) -> list[Transform]:
    """Where each frame's head was found, else where it was looked for."""
    found = {id(one.seen): one.T_face_camera for one in placed}
    return [found.get(id(one), start) for one, start in zip(seen, starts, strict=True)]


def coloured(
    average: RadiusMap,
    placed: list[PlacedFrame],
    reference: int,
    layout: CylinderLayout,
    take: RgbdTake,
    config: ColourConfig,
) -> CylinderMap:
    """The average with the frames' colours."""  # fmt: skip
    bare = surface_map(average, layout)
    normals = normals_of(bare.positions)
    chosen = chosen_frames(placed, reference, config)
    photos = [photograph(placed[i], bare.positions, normals, take.camera) for i in chosen]
    colors = blend(photos, layout.pixel_mm, config)
    return CylinderMap(layout, bare.positions, colors, bare.confidence, take.name)
