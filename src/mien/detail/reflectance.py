"""Reflectance that changes with the expression: the same polynomials for albedo, dots taken out (sec. 4.2, 6)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import cKDTree

from ..mesh import Attachment
from ..progress import SILENT, Progress
from .domain import Domain, deformation_vectors
from .fields import DetailMap
from .polynomial import PolynomialConfig, PolynomialFit, PolynomialMap
from .sampling import interpolated
from .texture_space import Texels, with_gutter
from .training import Clip, HeadMarkers, TrainingSet, aligned_frames

LEAST_SHOWN = 0.5
"""Share of the frames that must show a texel: at a dot's rim few do, of one expression, and say nothing of the rest."""


@dataclass(frozen=True)
class ReflectanceConfig:
    """How the colour of the skin is learnt."""

    learn: bool = True
    """Of clips that have colours; False: displacements alone."""
    dot_radius_mm: float = 3.0
    """Skin this near to a marker's foot is hidden by its dot, or smudged by it; 0: there are no dots in the colours."""
    polynomial: PolynomialConfig = PolynomialConfig()


def coloured_clips(training: TrainingSet) -> tuple[Clip, ...]:
    """The clips whose first frame has colours."""
    clips = []
    for clip in training.clips:
        first = next(iter(clip.frames()), None)
        if first is not None and first.colors is not None:
            clips.append(clip)
    return tuple(clips)


def fit_reflectance(
    training: TrainingSet,
    head: HeadMarkers,
    domain: Domain,
    medium: DetailMap,
    on_training: Attachment,
    config: ReflectanceConfig = ReflectanceConfig(),
    progress: Progress = SILENT,
) -> DetailMap:
    """Three channels of linear albedo as functions of d1 and d2.

    A texel under a dot is left out of its frame: it is learnt from frames in which the dot lies elsewhere, and where
    there is none its coefficients are its surroundings', and `seen` is False. Frames without colours teach nothing.

    Args:
        medium: on whose texels the colours are learnt.
        on_training: those texels on the training topology (`BaseMesh.on_training`).

    Raises:
        BadInput: fewer than two frames with colours.
    """
    grid, field = medium.texels, medium.field
    fit = PolynomialFit(len(grid.pixels), 3, config.polynomial)
    for number, aligned in enumerate(aligned_frames(training, head), 1):
        progress.update("reflectance", number, len(training))
        if aligned.colors is None:
            continue
        colors = interpolated(aligned.colors.astype(float), on_training, training.mesh.faces)
        skin = interpolated(aligned.vertices, on_training, training.mesh.faces)
        colors[under_dots(skin, aligned.markers, config.dot_radius_mm)] = np.nan
        vectors = deformation_vectors(domain.strains, aligned.markers[None])[0]
        fit.add(field.parameters(vectors), colors)
    known = fit.share >= LEAST_SHOWN
    learnt = replace(fit.solve(), seen=known)
    error = np.where(known, fit.rms(learnt), np.nan)
    return DetailMap(grid, field, inpainted(grid, learnt), error, np.zeros(len(known), bool))


def under_dots(
    skin: Float[np.ndarray, "p 3"], markers: Float[np.ndarray, "k 3"], radius_mm: float
) -> Bool[np.ndarray, " p"]:
    """Points within a radius of the foot of any marker: the point of skin nearest to it."""
    hidden = np.zeros(len(skin), bool)
    shown = np.flatnonzero(np.isfinite(skin).all(axis=1))
    if radius_mm <= 0 or not len(shown):
        return hidden
    tree = cKDTree(skin[shown])
    _, foot = tree.query(markers)
    for near in tree.query_ball_point(skin[shown[foot]], radius_mm):
        hidden[shown[near]] = True
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
    return replace(learnt, coefficients=coefficients)


RELAXATIONS = 60
"""Rounds of averaging over filled texels: a dot is some twenty texels wide."""


def _around(rows: np.ndarray, columns: np.ndarray, size: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        yield np.clip(rows + down, 0, size - 1), np.clip(columns + right, 0, size - 1)
