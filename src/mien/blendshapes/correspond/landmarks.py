"""Landmarks on a map, and which of two maps' count (Casas et al. 2016, sec. 4.2)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from ...errors import BadInput
from ...landmarks.detector import COUNT, LOOPS, bundled_landmarks
from ...landmarks.lift import landmarks_near
from ...landmarks.look import LiftConfig
from ...transforms import Transform
from ..cylinder_map import CylinderLayout, CylinderMap, mesh_of_map

LOOK = LiftConfig(pixels=512, views=((0.0, 0.0), (-0.3, 0.0), (0.3, 0.0), (0.0, 0.18), (0.0, -0.15)))
"""Frontal and turned pictures of the scan."""
SURFACE_MM = 1.0
"""The scan is drawn from every so many millimetres."""
UNSURE_MM = 4.0
"""A landmark on which the pictures disagree by more is not known."""


@dataclass(frozen=True)
class MapLandmarks:
    """MediaPipe's 478 landmarks on a map."""

    points: Float[np.ndarray, "478 3"]
    """Face space, mm; NaN where not known."""
    known: Bool[np.ndarray, " 478"]

    def pixels(self, layout: CylinderLayout) -> Float[np.ndarray, "478 2"]:
        """Where they are in the map."""
        return layout.pixels(self.points)

    def moved(self, T: Transform) -> "MapLandmarks":
        """The same after the map was moved."""
        return replace(self, points=T.apply(self.points))

    def edited(self, points: dict[int, Float[np.ndarray, " 3"] | None]) -> "MapLandmarks":
        """Some moved or added (mm), or dropped where None, by hand."""
        places, known = self.points.copy(), self.known.copy()
        for number, point in points.items():
            known[number] = point is not None
            places[number] = np.nan if point is None else point
        return MapLandmarks(places, known)


def landmarks_on_map(map_: CylinderMap) -> MapLandmarks:
    """Landmarks of pictures from the front and the sides, lifted to the surface.

    Raises:
        BadInput: no picture shows a face.
    """
    surface = mesh_of_map(map_, max(1, round(SURFACE_MM / map_.layout.pixel_mm)))
    seen = landmarks_near(surface, Transform.identity(), LOOK)
    if seen is None:
        raise BadInput(f"{map_.name}: no face is found in pictures of it")
    points, deviation = seen
    known = np.isfinite(points[:, 0]) & (np.nan_to_num(deviation, nan=np.inf) < UNSURE_MM)
    return MapLandmarks(points, known)


def common_landmarks(first: MapLandmarks, second: MapLandmarks) -> Bool[np.ndarray, " 478"]:
    """Those that are known in both scans and keep to the skin: outline and irises slide (sec. 4.2)."""
    keeps = np.zeros(COUNT, bool)
    keeps[bundled_landmarks().stable] = True
    return first.known & second.known & keeps


def opened(pixels: Float[np.ndarray, "478 2"], least: float = 0.5) -> Float[np.ndarray, "478 2"]:
    """The pixels with upper lids and lips above the lower ones: where they cross, both go to `least` px apart."""
    out = pixels.copy()
    for upper, lower in ACROSS:
        gap = out[lower, 1] - out[upper, 1]
        if gap < least:
            middle = (out[lower] + out[upper]) / 2
            half = np.array([0.0, least / 2])
            out[upper], out[lower] = middle - half, middle + half
    return out


def mouth_opening(source: Float[np.ndarray, "478 2"], neutral: Float[np.ndarray, "478 2"]) -> float:
    """By how many pixels the lips are farther apart in the source, where they are most; 0 where nothing tells."""
    upper, lower = np.array(LIPS).T
    gaps = [pixels[lower, 1] - pixels[upper, 1] for pixels in (source, neutral)]
    return float(np.nan_to_num(gaps[0] - gaps[1]).max(initial=0.0))


def _across(loop: str) -> list[tuple[int, int]]:
    """Pairs (upper, lower) across an opening: loops run along the lower edge and back along the upper one."""
    points = LOOPS[loop]
    half = len(points) // 2
    return [(points[-i], points[i]) for i in range(1, half)]


LIPS = _across("lips_inner")
ACROSS = [*LIPS, *_across("eye_left"), *_across("eye_right")]
"""Landmarks (upper, lower) that face each other over the mouth and the eyes."""


def _edges(loop: str, name: str) -> dict[str, tuple[int, ...]]:
    """The lower and the upper edge of a loop, both from corner to corner."""
    points = LOOPS[loop]
    half = len(points) // 2
    return {f"{name}lower": points[: half + 1], f"{name}upper": (points[0], *reversed(points[half:]))}


EDGES = {
    **{f"{name}_lip": points for name, points in _edges("lips_inner", "").items()},
    **{f"{name}_lid": points for name, points in _edges("eye_left", "left_").items()},
    **{f"{name}_lid": points for name, points in _edges("eye_right", "right_").items()},
}
"""Landmarks along each of the bundled face's contours."""


def along_contours(
    vertices: Float[np.ndarray, "n 3"],
    contours: dict[str, Int[np.ndarray, " _"]],
    source: MapLandmarks,
    neutral: MapLandmarks,
) -> Float[np.ndarray, "n 3"]:
    """How lids and lips moved along their edges (`contours`, of the mesh), by landmarks there; NaN elsewhere, mm.

    Where landmarks of an edge are missing it says nothing: from one side of the gap to the other it would cut a corner.
    """
    moved = np.full(vertices.shape, np.nan)
    both = source.known & neutral.known
    for name, members in contours.items():
        ids = np.array([i for i in EDGES.get(name, ()) if neutral.known[i]], int)
        if both[ids].sum() < 3 or not len(members):
            continue
        ids = ids[np.argsort(neutral.points[ids, 0])]
        steps = np.where(both[ids, None], source.points[ids] - neutral.points[ids], np.nan)
        for axis in range(3):
            moved[members, axis] = np.interp(vertices[members, 0], neutral.points[ids, 0], steps[:, axis])
    return moved
