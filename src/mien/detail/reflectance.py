"""Reflectance that changes with the expression: the same polynomials for albedo, dots taken out (sec. 4.2, 6)."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import cKDTree

from ..errors import BadInput
from ..mesh import Attachment
from .domain import deformation_vectors
from .fields import parameter_field
from .fit import DetailConfig, DetailMap, DetailModel
from .polynomial import PolynomialFit, PolynomialMap
from .sampling import interpolated
from .texture_space import Texels, with_gutter
from .training import TrainingSet, aligned_frames

LEAST_SHOWN = 0.5
"""Share of the frames that must show a texel: at a dot's rim few do, of one expression, and say nothing of the rest."""
DOT_RADIUS_MM = 3.0
"""Skin this near to a marker's foot is hidden by its dot, or smudged by it."""


def fit_reflectance(
    training: TrainingSet,
    model: DetailModel,
    on_training: Attachment,
    config: DetailConfig = DetailConfig(),
    dot_radius_mm: float = DOT_RADIUS_MM,
) -> DetailMap:
    """Three channels of albedo as functions of d1 and d2.

    A texel under a dot is left out of its frame: it is learnt from frames in which the dot lies elsewhere, and where
    there is none its coefficients are its surroundings'.

    Args:
        on_training: the texels of the medium map on the training topology (`BaseMesh.on_training`).
        dot_radius_mm: 0 keeps the dots.

    Raises:
        BadInput: frames without colours.
    """
    grid = model.medium.texels
    field = parameter_field(model.domain, model.base, model.attachment, grid.attachment)
    fit = PolynomialFit(len(grid.pixels), 3, config.medium)
    for aligned in aligned_frames(training, model.head):
        if aligned.colors is None:
            raise BadInput("reflectance: frames without colours; give meshes with a colour at each vertex")
        colors = interpolated(aligned.colors.astype(float), on_training, training.mesh.faces)
        skin = interpolated(aligned.vertices, on_training, training.mesh.faces)
        colors[under_dots(skin, aligned.markers, dot_radius_mm)] = np.nan
        vectors = deformation_vectors(model.domain.strains, aligned.markers[None])[0]
        fit.add(field.parameters(vectors), colors)
    learnt = fit.solve()
    error, known = fit.rms(learnt), fit.share >= LEAST_SHOWN
    return DetailMap(grid, field, inpainted(grid, replace(learnt, seen=known)), error, ~known)


def under_dots(
    skin: Float[np.ndarray, "p 3"], markers: Float[np.ndarray, "k 3"], radius_mm: float
) -> Bool[np.ndarray, " p"]:
    """Points within a radius of the foot of any marker: the point of skin nearest to it."""
    hidden = np.zeros(len(skin), bool)
    if radius_mm <= 0:
        return hidden
    tree = cKDTree(skin)
    _, foot = tree.query(markers)
    for near in tree.query_ball_point(skin[foot], radius_mm):
        hidden[near] = True
    return hidden


def inpainted(grid: Texels, learnt: PolynomialMap) -> PolynomialMap:
    """Texels that no frame showed take the coefficients round them: the nearest's first, then smoothed over."""
    unknown = ~learnt.seen
    if not unknown.any() or unknown.all():
        return learnt
    image = grid.image(np.where(learnt.seen[:, None, None], learnt.coefficients, np.nan))
    image = with_gutter(image)
    open_ = np.zeros((grid.size, grid.size), bool)
    open_.flat[grid.pixels[unknown]] = True
    rows, columns = np.nonzero(open_)
    for _ in range(RELAXATIONS):
        image[rows, columns] = sum(image[r, c] for r, c in _around(rows, columns, grid.size)) / 4
    coefficients = np.ascontiguousarray(grid.of_image(image), np.float32)
    return PolynomialMap(coefficients, learnt.order, np.ones(len(grid.pixels), bool))


RELAXATIONS = 60
"""Rounds of averaging over filled texels: a dot is some twenty texels wide."""


def _around(rows: np.ndarray, columns: np.ndarray, size: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        yield np.clip(rows + down, 0, size - 1), np.clip(columns + right, 0, size - 1)
