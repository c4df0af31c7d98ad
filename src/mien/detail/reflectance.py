"""Reflectance that changes with the expression: the same polynomials for albedo, dots taken out (sec. 4.2, 6)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from ..progress import SILENT, Progress
from .base_mesh import BaseMesh
from .domain import Domain, deformation_vectors
from .fields import DetailMap, DrivenMap, ParameterField
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
    base: BaseMesh,
    medium: DetailMap,
    config: ReflectanceConfig = ReflectanceConfig(),
    progress: Progress = SILENT,
) -> DetailMap:
    """Three channels of linear albedo as functions of d1 and d2.

    A texel under a dot is left out of its frame: it is learnt from frames in which the dot lies elsewhere, and where
    there are too few from its surroundings, and `seen` is False. Frames without colours teach nothing. Of a deformation
    that no clip showed a polynomial may say green: no channel leaves the range that was seen there, or beside a dot.

    Args:
        medium: on whose texels the colours are learnt.

    Raises:
        BadInput: fewer than two frames with colours.
    """
    grid, field = medium.texels, medium.field
    on_training = base.on_training(grid.attachment)
    fit, shown = PolynomialFit(len(grid.pixels), 3, config.polynomial), []
    least, greatest = np.full((2, len(grid.pixels), 3), np.nan, np.float32)
    for number, aligned in enumerate(aligned_frames(training, head), 1):
        progress.update("reflectance", number, len(training))
        if aligned.colors is None:
            continue
        colors = interpolated(aligned.colors.astype(float), on_training, training.mesh.faces)
        skin = interpolated(aligned.vertices, on_training, training.mesh.faces)
        colors[under_dots(skin, aligned.markers, config.dot_radius_mm)] = np.nan
        vectors = deformation_vectors(domain.strains, aligned.markers[None])[0]
        fit.add(field.parameters(vectors, config.polynomial.whole_deformation), colors)
        shown.append(vectors)
        beside = grid.of_image(with_gutter(grid.image(colors))).astype(np.float32)
        least, greatest = np.fmin(least, beside), np.fmax(greatest, beside)
    known = fit.share >= LEAST_SHOWN
    learnt = replace(fit.solve(), seen=known, limits=np.stack([least, greatest], 1))
    error = np.where(known, fit.rms(learnt), np.nan)
    whole = with_covered(grid, field, learnt, shown, config.polynomial)
    return DetailMap(grid, field, whole, error, np.zeros(len(known), bool))


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


def with_covered(
    grid: Texels, field: ParameterField, learnt: PolynomialMap, shown: Sequence[Float[np.ndarray, "k 5"]],
    config: PolynomialConfig,
) -> PolynomialMap:  # fmt: skip
    """Texels that too few frames showed are learnt from what lies round them in each frame of training.

    From its surroundings a texel cannot take coefficients, which mean something under their own d1 and d2 alone.

    Args:
        shown: deformation vectors of those frames.
    """
    open_ = ~learnt.seen
    if not open_.any() or open_.all():
        return learnt
    driven, fill = DrivenMap(field, learnt), HarmonicFill(grid, learnt.seen)
    fit = PolynomialFit(int(open_.sum()), 3, config)
    least, greatest = np.full((2, int(open_.sum()), 3), np.nan, np.float32)
    for vectors in shown:
        colors = fill(driven.values(vectors))
        fit.add(field.parameters(vectors, config.whole_deformation)[open_], colors)
        least, greatest = np.fmin(least, colors), np.fmax(greatest, colors)
    assert learnt.limits is not None
    coefficients, limits = learnt.coefficients.copy(), learnt.limits.copy()
    coefficients[open_] = fit.solve().coefficients
    limits[open_] = np.stack([least, greatest], 1)
    return replace(learnt, coefficients=coefficients, limits=limits)


class HarmonicFill:
    """Values at unknown texels from the known ones round them: each the mean of its four neighbours."""

    def __init__(self, grid: Texels, known: Bool[np.ndarray, " p"]):
        joined = _four_neighbours(grid)
        open_ = np.flatnonzero(~known)
        own = joined[open_][:, open_] - sp.diags(joined[open_].sum(axis=1).A1 + TO_NEAREST)
        self._known, self._beside = known, sp.csr_matrix(joined[open_][:, np.flatnonzero(known)])
        numbers = grid.image(np.where(known, np.arange(len(known)), np.nan))
        self._nearest = grid.of_image(with_gutter(numbers)).astype(np.int64)[open_]
        self._factor = splu(sp.csc_matrix(-own))

    def __call__(self, values: Float[np.ndarray, "p c"]) -> Float[np.ndarray, "j c"]:
        """At the unknown texels alone."""
        pull = self._beside @ values[self._known] + TO_NEAREST * values[self._nearest]
        return self._factor.solve(np.asarray(pull, float))


TO_NEAREST = 1e-4
"""Weight of the nearest known texel beside four neighbours' of 1: islands that touch none take its value."""


def _four_neighbours(grid: Texels) -> sp.csr_matrix:
    """(p, p): 1 where two texels on the surface share a side."""
    numbers = np.full(grid.size**2, -1)
    numbers[grid.pixels] = np.arange(len(grid.pixels))
    image = numbers.reshape(grid.size, grid.size)
    pairs = [(image[:, :-1].ravel(), image[:, 1:].ravel()), (image[:-1].ravel(), image[1:].ravel())]
    i, j = (np.concatenate(side) for side in zip(*pairs, strict=True))
    both = (i >= 0) & (j >= 0)
    half = sp.csr_matrix((np.ones(both.sum()), (i[both], j[both])), shape=(len(grid.pixels),) * 2)
    return sp.csr_matrix(half + half.T)
