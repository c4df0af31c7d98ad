"""Upper edges of the brows by the skin's own colour: MediaPipe's brows lie up to 5 mm inside or above them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.ndimage import gaussian_filter, map_coordinates

from ..mesh import Mesh
from ..pictures.raycast import RayCaster
from ..pictures.render import Lamp, Look, Renderer
from ..pictures.view import View, frontal_camera
from .look import lift_pixels

BROW_EDGES = ((107, 66, 105, 63, 70), (336, 296, 334, 293, 300))
"""Landmarks along the upper edge of the right and the left brow, from within outwards."""
UNLIT = Look(
    supersample=1, key=Lamp((0.0, 0.0, -1.0), (0.0, 0.0, 0.0)), others=(),
    sky=(1.0, 1.0, 1.0), ground=(1.0, 1.0, 1.0), reflectance=0.0, occlusion=0, softness=0.0,
)  # fmt: skip
"""The surface's own colour, without light and shade."""
DARKEST = 8.0
"""Added to grey values (of 255) before their logarithm, so that noise of black is no edge."""
FLANK = 2.5
"""The brow's and the skin's tone are compared so far to either side of an edge, mm."""


@dataclass(frozen=True)
class BrowConfig:
    """How edges of brows are looked for. Lengths in millimetres."""

    pixels: int = 640
    """Side of the picture, which the two brows fill from side to side."""
    columns: int = 48
    """Places along a brow."""
    reach: float = 7.0
    """How far from the landmarks an edge is looked for, up and down."""
    step: float = 0.25
    """Between the places tried."""
    blur: tuple[float, float] = (1.5, 0.6)
    """Standard deviations along and across a brow, by which hairs are blurred: they are no edges."""
    bend: float = 0.02
    """Price of an edge's step up or down from column to column, squared, in mean strengths of an edge."""
    least_contrast: float = 0.08
    """Where the skin above is not lighter than the brow by this share there is no edge: fair brows, hats."""


def brow_edges(
    mesh: Mesh,
    texture: np.ndarray | None,
    points: Float[np.ndarray, "478 3"],
    config: BrowConfig = BrowConfig(),
) -> Float[np.ndarray, "2 c 3"]:
    """Where dark hair goes over into lighter skin, along each of `BROW_EDGES` from its first landmark to its last.

    NaN where nothing was found. How far along the brow a landmark lies no edge says.

    Args:
        mesh: a scan in face space, mm, with `texture` or vertex colours; without either nothing is found.
        points: MediaPipe's landmarks on it; NaN where not seen.
    """
    edges = np.full((2, config.columns, 3), np.nan)
    there = points[np.array(BROW_EDGES)]
    if (texture is None and mesh.colors is None) or not np.isfinite(there).all():
        return edges
    view = frontal_camera(mesh, config.pixels, frame=there.reshape(-1, 3), margin=0.15)
    picture = Renderer(mesh, UNLIT, texture).draw(*view)
    tones = np.log(picture.mean(axis=2) + DARKEST)
    caster = RayCaster(mesh)
    for side, line in enumerate(there):
        pixels = _edge(tones, view, line, config)
        if pixels is not None:
            edges[side] = lift_pixels(caster, view, pixels)[1]
    return edges


def _edge(
    tones: Float[np.ndarray, "h w"], view: View, line: Float[np.ndarray, "5 3"], config: BrowConfig
) -> Float[np.ndarray, "c 2"] | None:
    """Pixels of a brow's upper edge beside the landmarks of `line`; None without contrast."""
    seen = view.T_camera_face.apply(line)
    pixels_a_mm = view.camera.fx / seen[:, 2].mean()
    course, up = _smooth_course(view.camera.project(seen), config.columns)
    heights = np.arange(-config.reach, config.reach + config.step / 2, config.step)
    places = course[:, None] + pixels_a_mm * heights[None, :, None] * up[:, None]
    strip = map_coordinates(tones, places[..., ::-1].transpose(2, 0, 1), order=1, mode="nearest")
    spacing = np.linalg.norm(np.diff(course, axis=0), axis=1).mean() / pixels_a_mm
    blur = (config.blur[0] / spacing, config.blur[1] / config.step)
    strip = gaussian_filter(strip, blur, mode="nearest")
    rise = np.gradient(strip, config.step, axis=1)
    path = best_path(rise, config.bend * float(np.abs(rise).mean()))
    if _contrast(strip, path, round(FLANK / config.step)) < config.least_contrast:
        return None
    return course + pixels_a_mm * heights[path, None] * up


def _smooth_course(pixels: Float[np.ndarray, "5 2"], columns: int) -> tuple[np.ndarray, np.ndarray]:
    """A cubic through a brow's landmarks, at `columns` places, and the picture's way up square to it."""
    at, between = np.arange(len(pixels)), np.linspace(0, len(pixels) - 1, columns)
    course = np.stack([np.polyval(np.polyfit(at, axis, 3), between) for axis in pixels.T], axis=1)
    along = np.gradient(course, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    return course, across * np.where(across[:, 1:] > 0, -1.0, 1.0)


def _contrast(strip: Float[np.ndarray, "c r"], path: Int[np.ndarray, " c"], flank: int) -> float:
    """By how much the skin above an edge is lighter than the brow below: median difference of logarithms."""
    columns, last = np.arange(len(path)), strip.shape[1] - 1
    above = strip[columns, np.minimum(path + flank, last)]
    below = strip[columns, np.maximum(path - flank, 0)]
    return float(np.median(above - below))


def best_path(gain: Float[np.ndarray, "c r"], bend: float) -> Int[np.ndarray, " c"]:
    """One row a column: the largest sum of gains, less `bend` times the squared steps between columns (Viterbi)."""
    columns, rows = gain.shape
    price = bend * np.subtract.outer(np.arange(rows), np.arange(rows)) ** 2
    total, came_from = gain[0], np.zeros((columns, rows), int)
    for column in range(1, columns):
        ways = total - price
        came_from[column] = ways.argmax(axis=1)
        total = ways.max(axis=1) + gain[column]
    path = np.empty(columns, int)
    path[-1] = total.argmax()
    for column in range(columns - 1, 0, -1):
        path[column - 1] = came_from[column, path[column]]
    return path
