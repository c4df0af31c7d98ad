"""The average of the frames so far: frames are laid on it, fused into it, and give it their colours."""

import numpy as np

from ...camera import Camera
from ...errors import BadInput
from ...mesh import ClosestPoint
from ...rgbd import RgbdTake
from ...transforms import Transform
from ..cylinder_map import CylinderLayout, CylinderMap, mesh_of_map
from .colour import ColourConfig, blend, chosen_frames, normals_of, photograph
from .frames import FramesConfig, PlacedFrame, SeenFrame, place_by_landmarks, place_by_surface
from .fuse import FuseConfig, RadiusMap, fuse, radius_of_frame

COARSE_MM = 1.0
"""Side of the pixels of the map that frames are registered to, mm."""
LEAST_FRAMES = 3
"""A scan is made of so many frames at least."""


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


def enough(placed: list[PlacedFrame], seen: list[SeenFrame], name: str) -> None:
    """See that the scan is made of more than the reference frame, where there are more.

    Raises:
        BadInput: hardly a frame could be registered.
    """
    if len(placed) < min(LEAST_FRAMES, len(seen)):
        told = f"only {len(placed)} of {len(seen)} frames could be registered"
        raise BadInput(f"{name}: {told}; hold still and turn the head slowly")


def layouts(pixel_mm: float) -> tuple[CylinderLayout, CylinderLayout]:
    """The scan's own layout, and the coarser one that frames are registered in."""
    return CylinderLayout(pixel_mm), CylinderLayout(max(COARSE_MM, pixel_mm))
