"""What colour a person is: the bundled face's paint, turned into one person's, with mottling, moles and brow hair."""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float
from scipy.spatial import KDTree

from ...mesh import Mesh
from .fields import smooth_field

BROWN = np.array([0.30, 0.20, 0.15])
FLUSH = np.array([0.04, -0.06, -0.05])
"""sRGB that squeezed skin gains at the most; stretched skin loses it."""
FLUSHED_AT = 0.15
"""Loss of area by which most of the blood that will move has moved."""


def blood_moved(compression: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 3"]:
    """What is added to the colour (sRGB) of skin that has lost a share of its area, negative where it has gained."""
    return np.tanh(compression / FLUSHED_AT)[:, None] * FLUSH


def albedo(
    coarse: Mesh,
    smooth: sp.csr_matrix,
    straight: sp.csr_matrix,
    points: Float[np.ndarray, "n 3"],
    is_skin: Bool[np.ndarray, " n"],
    rng: np.random.Generator,
) -> Float[np.ndarray, "n 3"]:
    """Vertex colours, sRGB in 0..1, of a skin subdivided from `coarse`; eyes and teeth keep theirs."""
    paint = coarse.colors if coarse.colors is not None else np.full((len(coarse.vertices), 3), 0.7)
    base = np.asarray(straight @ paint)
    base[is_skin] = (smooth @ paint)[is_skin]
    tone = np.array([1.0, 0.96, 0.92]) ** rng.uniform(-1.0, 4.0) * rng.uniform(0.6, 1.03)
    blood = 0.010 * smooth_field(rng, (10.0, 45.0), waves=64).at(points) * [1.0, -0.5, -0.4]
    mottle = 0.010 * smooth_field(rng, (2.5, 9.0), waves=64).at(points)
    grain = 0.012 * rng.normal(size=(len(points), 1))
    skin = base * tone + blood + mottle + grain
    skin = _brow_hair(skin, base, points, rng)
    skin = _moles(skin, points, rng)
    return np.clip(np.where(is_skin[:, None], skin, base), 0.0, 1.0)


def _brow_hair(skin: np.ndarray, base: np.ndarray, points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Darken and streak where the paint is brow: darker than skin and above the eyes."""
    luminance = base @ [0.3, 0.6, 0.1]
    brow = np.clip((np.median(luminance) - luminance - 0.03) / 0.15, 0, 1) * (points[:, 1] > 8) * (points[:, 2] > 35)
    lean = points[:, 0] * 0.9 - np.sign(points[:, 0]) * points[:, 1] * 0.7
    streaks = 0.5 + 0.5 * np.sin(2 * np.pi * lean / 1.9 + 1.5 * smooth_field(rng, (3.0, 9.0)).at(points)[:, 0])
    share = (brow * (0.45 + 0.5 * streaks))[:, None]
    return skin * (1 - share) + BROWN * rng.uniform(0.5, 1.3) * share


def _moles(skin: np.ndarray, points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A few brown spots of 1 to 3 mm, and many faint freckles."""
    tree, skin = KDTree(points), skin.copy()
    front = np.flatnonzero(points[:, 2] > 30)
    for size, count, dark in ((1.3, rng.integers(3, 9), 0.55), (0.8, rng.integers(20, 120), 0.15)):
        for centre in points[rng.choice(front, count)]:
            here = tree.query_ball_point(centre, 3 * size)
            distance = np.linalg.norm(points[here] - centre, axis=1)
            spot = dark * np.exp(-((distance / (size * rng.uniform(0.6, 1.2))) ** 4))[:, None]
            skin[here] = skin[here] * (1 - spot) + BROWN * spot
    return skin
