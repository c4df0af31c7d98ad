"""Expressions brought into the neutral's frame by what does not move: the forehead (Casas et al. 2016, sec. 3)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import BadInput
from ..mesh import SurfaceImage
from ..register import procrustes_robust
from ..register.correspond import Rejection, Surface
from ..register.rigid_icp import closest_point_rounds, plane_system, point_system
from ..transforms import Transform
from .correspond.landmarks import MapLandmarks
from .correspond.occlusion import polygon
from .cylinder_map import CylinderMap, mesh_of_map, outermost_first

BROW_TOPS = (70, 63, 105, 66, 107, 9, 336, 296, 334, 293, 300)
"""Landmarks along the brows' upper edges, from the subject's right to the left."""
TEMPLES = (54, 103, 67, 109, 10, 338, 297, 332, 284)
"""Landmarks along the face's upper outline."""
BRIDGE = (168, 6, 197, 195, 122, 351, 193, 417)
"""Landmarks on the nose's bridge, which moves least of all."""
STEADY = (*BRIDGE, 133, 362, 33, 263, 9, 151, 10, 67, 297, 109, 338)
"""Landmarks of eye corners, bridge and forehead, by which two heads are first laid on each other."""
OFF_PLANE_MM, OFF_MARK_MM = 0.8, 2.0
"""A point so far off its plane, a landmark so far off its place, counts a quarter."""
STILL_MM = 0.5
"""Skin that moves within the head by so much counts a quarter when the head is held still."""
SETTLED_MM = 0.01
"""ICP ends when a step moves no point by more."""
BRIDGE_MM = 7.0
"""Skin this near to a landmark of the bridge counts with the forehead."""


@dataclass(frozen=True)
class HeadAlignConfig:
    """How an expression's head is laid on the neutral one's."""

    bridge: bool = True
    """The nose's bridge counts with the forehead: a forehead alone, nearly a ball, lets the head turn on it."""
    landmark_share: float = 0.05
    """Weight of all steady landmarks together, against 1 for the surface: a forehead slides on itself; 0: none."""
    reach_mm: float = 6.0
    """Points farther from the neutral than this do not count."""
    points: int = 3000
    """Points of the forehead that are used."""
    iterations: int = 25
    """Of the ICP."""


@dataclass(frozen=True)
class AlignedCapture:
    """A capture in the neutral's frame."""

    map: CylinderMap
    landmarks: MapLandmarks
    T_neutral_capture: Transform
    rms_mm: float
    """Of the forehead after ICP, mm."""


def align(
    source: CylinderMap,
    source_landmarks: MapLandmarks,
    neutral: CylinderMap,
    neutral_landmarks: MapLandmarks,
    config: HeadAlignConfig = HeadAlignConfig(),
) -> AlignedCapture:
    """Landmarks lay the heads on each other, then rigid ICP of the forehead alone; the points go back to the map.

    Raises:
        BadInput: no landmarks in common, or no forehead.
    """
    start = by_landmarks(source_landmarks, neutral_landmarks, source.name)
    still = forehead(source, source_landmarks, config.bridge)
    points = source.positions[still].astype(np.float64)
    if len(points) < 200:
        raise BadInput(f"{source.name}: shows no forehead to lay it on the neutral; is it cut off?")
    drawn = points[:: max(1, len(points) // config.points)]
    target = Surface(mesh_of_map(neutral, 2).mesh)
    ids = steady_landmarks(source_landmarks, neutral_landmarks)
    pairs = source_landmarks.points[ids], neutral_landmarks.points[ids]
    T, rms = laid_on(drawn, target, pairs, start, config)
    moved = source_landmarks.moved(T)
    return AlignedCapture(moved_map(source, T), moved, T, rms)


def laid_on(
    points: Float[np.ndarray, "p 3"],
    surface: Surface,
    pairs: tuple[Float[np.ndarray, "k 3"], Float[np.ndarray, "k 3"]],
    T: Transform,
    config: HeadAlignConfig = HeadAlignConfig(),
) -> tuple[Transform, float]:
    """Rigid ICP, point to plane, with landmarks (source, neutral) that hold what slides; and the rms distance, mm."""
    rule = Rejection(config.reach_mm, 180.0)

    def one_round(now: tuple[Transform, float]) -> tuple[tuple[Transform, float], bool]:
        T, _ = now
        moved, marks = T.apply(points), T.apply(pairs[0])
        found = surface.correspond(moved, None, rule)
        off = ((found.points - moved) * found.normals).sum(1)
        weight = found.accepted / (1 + (off / OFF_PLANE_MM) ** 2) ** 2
        away = pairs[1] - marks
        hold = 1 / (1 + ((away**2).sum(1) / OFF_MARK_MM**2)) ** 2
        hold = hold * config.landmark_share * weight.sum() / max(hold.sum(), 1e-9)
        system = plane_system(moved, found.normals, off, weight)
        step, _ = (system + point_system(marks, away, hold, system.centre)).solve()
        rms = float(np.sqrt(np.average(off**2, weights=weight + 1e-12)))
        return (step @ T, rms), bool(np.abs(step.apply(moved) - moved).max() < SETTLED_MM)

    return closest_point_rounds((T, 0.0), one_round, config.iterations).state


def stabilised(
    found: Float[np.ndarray, "n 3"], neutral: Float[np.ndarray, "n 3"], share: Float[np.ndarray, " n"]
) -> Transform:
    """T_neutral_found by the largest part of the face that moved as one (after Beeler and Bradley 2014).

    Past the paper: a forehead slides on itself, and brows move it. Once the skin corresponds, all of it says where the
    head is: far residuals lose weight, and what counts as far shrinks to `STILL_MM`.

    Args:
        found: points of the skin in the expression, mm; NaN where not seen.
        neutral: the same points in the neutral.
        share: of the surface that each stands for; 0 = not counted.
    """
    use = np.isfinite(found[:, 0]) & (share > 0)
    if use.sum() < 3:
        return Transform.identity()
    scales = (*np.geomspace(3.0, STILL_MM, 8), *[STILL_MM] * 4)
    return procrustes_robust(found[use], neutral[use], scales, share[use]).transform


def steady_landmarks(source: MapLandmarks, neutral: MapLandmarks) -> Int[np.ndarray, " k"]:
    """Those of `STEADY` that both scans have."""
    both = source.known & neutral.known
    return np.array([i for i in STEADY if both[i]], int)


def by_landmarks(source: MapLandmarks, neutral: MapLandmarks, name: str) -> Transform:
    """T_neutral_capture by eye corners, bridge and forehead.

    Raises:
        BadInput: fewer than six of them are known in both.
    """
    ids = steady_landmarks(source, neutral)
    if len(ids) < 6:
        raise BadInput(f"{name}: eyes and forehead are not found in it; it cannot be laid on the neutral")
    return procrustes_robust(source.points[ids], neutral.points[ids], [OFF_MARK_MM] * 5).transform


def forehead(map_: CylinderMap, landmarks: MapLandmarks, bridge: bool = True) -> Bool[np.ndarray, "h w"]:
    """Pixels between the brows and the face's upper outline; with `bridge` also those on the nose's bridge."""
    pixels = landmarks.pixels(map_.layout)
    outline = [i for i in (*BROW_TOPS, *reversed(TEMPLES)) if landmarks.known[i] or np.isfinite(pixels[i, 0])]
    mask = polygon(pixels[outline], map_.layout.shape)
    if bridge:
        rows, columns = np.mgrid[: mask.shape[0], : mask.shape[1]]
        for i in BRIDGE:
            if np.isfinite(pixels[i, 0]):
                near = (rows - pixels[i, 1]) ** 2 + (columns - pixels[i, 0]) ** 2
                mask |= near < (BRIDGE_MM / map_.layout.pixel_mm) ** 2
    return mask & map_.known & (map_.confidence > 0.05)


def moved_map(map_: CylinderMap, T: Transform) -> CylinderMap:
    """The map's surface moved and laid out anew."""
    surface = mesh_of_map(map_)
    mesh = surface.mesh.with_vertices(T.apply(surface.mesh.vertices))
    assert surface.mesh.uv is not None
    h, w = map_.layout.shape
    columns = np.round(surface.mesh.uv[:, 0] * w - 0.5).astype(int)
    rows = np.round((1 - surface.mesh.uv[:, 1]) * h - 0.5).astype(int)
    values = np.column_stack([mesh.vertices, map_.colors[rows, columns], map_.confidence[rows, columns]])
    places, faces = outermost_first(mesh, map_.layout)
    drawn = SurfaceImage(places, faces, map_.layout.shape).draw(values).astype(np.float32)
    confidence = np.nan_to_num(drawn[..., 6])
    return CylinderMap(map_.layout, drawn[..., :3], drawn[..., 3:6], confidence, map_.name)
