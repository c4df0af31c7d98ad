"""The face model on one scan of somebody unknown."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..faces.bundled import BundledFace
from ..landmarks.detector import LandmarkSet, bundled_landmarks
from ..mesh import Attachment
from ..register.correspond import Surface
from ..register.nonrigid import Anchors
from ..transforms import Transform
from .morphable import (
    PEOPLE_BOUND,
    FaceFit,
    FaceFitConfig,
    FaceState,
    MorphableModel,
    fit_face,
    identity_model,
    with_expressions,
)
from .template_parts import TemplateParts
from .terms import landmark_term, surface_term

SET_ASIDE = ("eyeLook", "tongueOut", "mouthClose")
"""Shapes that a scan's surface says nothing of, by the beginnings of their names."""


@dataclass(frozen=True)
class ModelFitConfig:
    """How the model is fitted to a scan. Millimetres throughout."""

    score_share: float = 0.7
    """Expected weight of an expression, as a share of MediaPipe's score for it; 0 expects a neutral face."""
    expression_deviation: float = 0.15
    """Standard deviation of an expression's weight about that."""
    identity_deviation: float = 1.0
    """Standard deviation of the identity's coefficients: 1 is the people that the space was made from."""
    landmark_sigma: float = 3.0
    """How wrong a landmark is expected to be."""
    landmark_agreement: float = 1.5
    """A landmark on which the views disagree by so much counts half."""
    surface_sigma: tuple[float, ...] = (8.0, 4.0, 2.0, 1.2, 0.8)
    """How far the surface is expected to be from the model, step by step: it begins to count late."""
    steps: int = 3
    """Gauss-Newton rounds at each of `surface_sigma`."""


@dataclass(frozen=True)
class ModelFit:
    """The model on a scan."""

    vertices: Float[np.ndarray, "n 3"]
    """The bundled topology in face space, mm."""
    T_model_target: Transform
    """Rigid: the target's frame -> face space, as the model's pose has it."""
    identity: Float[np.ndarray, " i"]
    """Standard deviations from the average."""
    expression: dict[str, float]
    """Weights, ARKit names."""
    converged: bool
    costs: dict[str, float]
    """Of each term, see `morphable.FaceFit`."""


def landmark_anchors(
    points: Float[np.ndarray, "478 3"],
    spread: Float[np.ndarray, " 478"],
    attachment: Attachment | None = None,
    config: ModelFitConfig = ModelFitConfig(),
    landmark_set: LandmarkSet | None = None,
) -> Anchors:
    """Landmarks of a scan with a weight each: less where views disagree, none on outline and irises.

    Args:
        points: target's frame, mm; NaN where not seen.
        spread: how far the views disagree, mm.
        attachment: where they lie on the bundled topology, the bundled face's own places by default.
    """
    landmark_set = landmark_set or bundled_landmarks()
    weights = np.zeros(len(points))
    seen = np.isfinite(points.sum(axis=1))
    steady = landmark_set.stable[seen[landmark_set.stable]]
    weights[steady] = 1 / (1 + (spread[steady] / config.landmark_agreement) ** 2)
    return Anchors(attachment or landmark_set.attachment, np.nan_to_num(points), weights)


def fit_person_to_scan(
    face: BundledFace,
    parts: TemplateParts,
    surface: Surface,
    anchors: Anchors,
    scores: dict[str, float],
    config: ModelFitConfig = ModelFitConfig(),
) -> ModelFit:
    """Identity, expression and pose of somebody unknown; half-way, lids and eyes are refitted to the person.

    Args:
        surface: aligned with face space but for a few centimetres and degrees, mm.
        anchors: landmarks on the bundled topology and their places in the surface's frame.
        scores: expressions as they were seen, ARKit names, 0..1: what is expected.
    """
    people = identity_model(face, config.identity_deviation, PEOPLE_BOUND)
    rough = _fit(face, parts, _expressive(people, face, face.rig.deltas, scores, config), surface, anchors, config)
    identity = rough.state.coefficients[: len(people.modes)]
    deltas = face.fitted_deltas(people.vertices(identity))
    model = _expressive(people, face, deltas, scores, config)
    last = replace(config, surface_sigma=config.surface_sigma[-2:])
    return _result(face, _fit(face, parts, model, surface, anchors, last, rough.state), len(people.modes))


def _expressive(
    people: MorphableModel, face: BundledFace, deltas: np.ndarray, scores: dict[str, float], config: ModelFitConfig
) -> MorphableModel:
    """The identity model with the expressions that a surface shows, each expected as seen."""
    names = _names(face)
    expected = np.array([config.score_share * scores.get(n, 0.0) for n in names])
    chosen = deltas[[face.rig.index(n) for n in names]]
    return with_expressions(people, chosen, expected, config.expression_deviation)


def _names(face: BundledFace) -> list[str]:
    return [n for n in face.rig.names if not n.startswith(SET_ASIDE)]


def _fit(
    face: BundledFace,
    parts: TemplateParts,
    model: MorphableModel,
    surface: Surface,
    anchors: Anchors,
    config: ModelFitConfig,
    start: FaceState | None = None,
) -> FaceFit:
    """The model on surface and landmarks, `steps` rounds at each of the surface's sigmas."""
    trust = face.regions["face"] * (parts.trust > 0)
    sigma = np.repeat(config.surface_sigma, config.steps).tolist()
    on_face, goals, weights = anchors.attachment, anchors.points, anchors.weights
    terms = {
        "surface": surface_term(model, surface, trust, sides=parts.sides, sigma=sigma),
        "landmarks": landmark_term(model, on_face, goals, weights, sigma=config.landmark_sigma),
    }
    return fit_face(model, terms, FaceFitConfig(rounds=len(sigma)), start)


def _result(face: BundledFace, fit: FaceFit, people: int) -> ModelFit:
    identity, expression = np.split(fit.state.coefficients, [people])
    return ModelFit(
        vertices=fit.vertices,
        T_model_target=fit.state.T_target_model.inverse(),
        identity=identity,
        expression=dict(zip(_names(face), expression.tolist(), strict=True)),
        converged=fit.converged,
        costs=fit.costs,
    )
