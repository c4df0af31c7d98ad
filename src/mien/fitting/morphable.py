"""A linear face model fitted to anything: one Gauss-Newton over pose, coefficients and stand-off; terms are its data.

Terms are in `terms.py`, each a few lines; a new kind of measurement is a new term and no new solver.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from ..faces.bundled import BundledFace
from ..mesh import Attachment, Mesh
from ..solve import box_least_squares
from ..transforms import Transform, rotation_from_vector, skew

POSE = 6
"""The first unknowns: a turn about the model's placed origin (radians), then a shift (mm)."""
PEOPLE_BOUND = 3.5
"""Identity coefficients stay within so many standard deviations: one person in two thousand lies beyond."""
WEAKEST = 1e-9
"""Share of the mean curvature with which directions that no term holds are held where they are."""


@dataclass(frozen=True)
class MorphableModel:
    """x = mean + sum_k c_k modes_k, each c_k normal about `expected` with `deviation`, within its bounds."""

    mean: Float[np.ndarray, "n 3"]
    """Millimetres, the model's own frame (face space for the bundled face)."""
    faces: Int[np.ndarray, "m 3"]
    modes: Float[np.ndarray, "k n 3"]
    expected: Float[np.ndarray, " k"]
    deviation: Float[np.ndarray, " k"]
    """Standard deviations; 0 holds a coefficient where it is expected."""
    lower: Float[np.ndarray, " k"]
    """-inf where there is no bound."""
    upper: Float[np.ndarray, " k"]

    def vertices(self, coefficients: Float[np.ndarray, " k"]) -> Float[np.ndarray, "n 3"]:
        """The shape, model frame."""
        return self.mean + np.tensordot(coefficients, self.modes, axes=1)

    def mesh(self, coefficients: Float[np.ndarray, " k"]) -> Mesh:
        """The shape as a mesh."""
        return Mesh(self.vertices(coefficients), self.faces)


def identity_model(face: BundledFace, deviation: float = 1.0, bound: float = np.inf) -> MorphableModel:
    """Who it is: the bundled face's identity space alone, in standard deviations about the average."""
    k = len(face.identity.modes)
    return MorphableModel(
        mean=face.rig.neutral.vertices,
        faces=face.rig.neutral.faces,
        modes=face.identity.modes,
        expected=np.zeros(k),
        deviation=np.full(k, deviation),
        lower=np.full(k, -bound),
        upper=np.full(k, bound),
    )


def with_expressions(
    model: MorphableModel,
    deltas: Float[np.ndarray, "e n 3"],
    expected: Float[np.ndarray, " e"],
    deviation: float | Float[np.ndarray, " e"],
) -> MorphableModel:
    """The model with expression weights in 0..1 as further coefficients, after those that it has."""
    e = len(deltas)
    return replace(
        model,
        modes=np.concatenate([model.modes, deltas]),
        expected=np.r_[model.expected, expected],
        deviation=np.r_[model.deviation, np.broadcast_to(deviation, e)],
        lower=np.r_[model.lower, np.zeros(e)],
        upper=np.r_[model.upper, np.ones(e)],
    )


@dataclass(frozen=True)
class FaceState:
    """The unknowns."""

    coefficients: Float[np.ndarray, " k"]
    T_target_model: Transform
    """Rigid: the model's frame -> the frame of what was measured, mm."""
    standoff: float = 0.0
    """Distance of markers' centres from the skin, mm; only marker terms know of it."""

    def moved(self, step: Float[np.ndarray, " u"], model: MorphableModel) -> "FaceState":
        """The state after a step of all unknowns: turn, shift, coefficients (kept in bounds), stand-off."""
        T = self.T_target_model
        turned = rotation_from_vector(step[:3]) @ T.rotation
        coefficients = np.clip(self.coefficients + step[POSE:-1], model.lower, model.upper)
        return FaceState(coefficients, Transform(turned, T.translation + step[3:6]), self.standoff + float(step[-1]))


@dataclass(frozen=True)
class Rows:
    """What a term asks for: weighted residuals, goal less model, and how the model moves with the unknowns."""

    residual: Float[np.ndarray, " r"]
    """Already divided by the standard deviations, so that its squares add up."""
    jacobian: Float[np.ndarray, "r u"]
    """Derivative of the weighted model: turn (3), shift (3), coefficients (k), stand-off (1)."""


@runtime_checkable
class Term(Protocol):
    """One kind of measurement. `round` counts from 0: schedules tighten with it."""

    def rows(self, model: MorphableModel, state: FaceState, round: int) -> Rows:
        """Weighted residuals and Jacobian at `state`."""
        ...


@dataclass(frozen=True)
class FaceFitConfig:
    """The solver: how long, and what beside the coefficients is unknown."""

    rounds: int = 15
    """Gauss-Newton steps; terms look up their correspondences anew in each."""
    pose: bool = True
    """Whether the pose is unknown; False holds it where it starts."""
    standoff_mm: float = 3.0
    """Expected distance of markers' centres from the skin, mm."""
    standoff_deviation_mm: float = 1.0
    """How far the common stand-off may differ from that, mm."""
    settled_mm: float = 0.05
    """The fit has converged when the last step moved the model by less, rms, mm."""


@dataclass(frozen=True)
class FaceFit:
    """A fitted model."""

    state: FaceState
    vertices: Float[np.ndarray, "n 3"]
    """The model's shape in its own frame, mm."""
    converged: bool
    iterations: int
    costs: dict[str, float]
    """Sum of squared weighted residuals of each term, and of the `prior`, at the end."""


def fit_face(
    model: MorphableModel,
    terms: Mapping[str, Term],
    config: FaceFitConfig = FaceFitConfig(),
    start: FaceState | None = None,
) -> FaceFit:
    """Pose, coefficients and stand-off that minimise the squared rows of all terms and of the priors, within bounds.

    Maximum a posteriori by Gauss-Newton: each round stacks the terms' normal equations and takes the box-constrained
    step. The target must be aligned with the model but for a few centimetres and degrees, or `start` say how.
    """
    state = start or FaceState(model.expected.copy(), Transform.identity(), config.standoff_mm)
    state = replace(state, coefficients=np.clip(state.coefficients, model.lower, model.upper))
    moved = np.inf
    for round in range(config.rounds):
        gram, linear = _prior(model, state, config)
        for term in terms.values():
            rows = term.rows(model, state, round)
            gram += rows.jacobian.T @ rows.jacobian
            linear += rows.jacobian.T @ rows.residual
        before, state = state, state.moved(_box_step(gram, linear, model, state, config), model)
        moved = _distance(model, before, state)
    costs = {name: float((t.rows(model, state, config.rounds - 1).residual ** 2).sum()) for name, t in terms.items()}
    costs["prior"] = _prior_cost(model, state, config)
    return FaceFit(state, model.vertices(state.coefficients), moved < config.settled_mm, config.rounds, costs)


def _prior(model: MorphableModel, state: FaceState, config: FaceFitConfig) -> tuple[np.ndarray, np.ndarray]:
    """Normal equations of the priors on coefficients and stand-off."""
    precision = _precision(model, config)
    missing = np.r_[np.zeros(POSE), model.expected - state.coefficients, config.standoff_mm - state.standoff]
    return np.diag(precision), precision * missing


def _precision(model: MorphableModel, config: FaceFitConfig) -> np.ndarray:
    free = model.deviation > 0
    coefficients = np.where(free, 1 / np.where(free, model.deviation, 1.0) ** 2, 0.0)
    return np.r_[np.zeros(POSE), coefficients, 1 / config.standoff_deviation_mm**2]


def _prior_cost(model: MorphableModel, state: FaceState, config: FaceFitConfig) -> float:
    off = np.r_[np.zeros(POSE), state.coefficients - model.expected, state.standoff - config.standoff_mm]
    return float((_precision(model, config) * off**2).sum())


def _box_step(gram, linear, model: MorphableModel, state: FaceState, config: FaceFitConfig) -> Float[np.ndarray, " u"]:
    """The step within the coefficients' bounds, solved in units in which all unknowns are alike."""
    u, held = len(linear), np.flatnonzero(model.deviation == 0) + POSE
    free = np.setdiff1d(np.arange(0 if config.pose else POSE, u), held)
    gram, linear = gram[np.ix_(free, free)], linear[free]
    gram = gram + WEAKEST * np.trace(gram) / len(free) * np.eye(len(free))
    low = np.r_[np.full(POSE, -np.inf), model.lower - state.coefficients, -np.inf][free]
    high = np.r_[np.full(POSE, np.inf), model.upper - state.coefficients, np.inf][free]
    size = np.sqrt(np.diag(gram))
    scaled, right = gram / np.outer(size, size), linear / size
    step = np.zeros(u)
    if np.isinf(low).all() and np.isinf(high).all():
        step[free] = np.linalg.solve(scaled, right) / size
    else:
        step[free] = box_least_squares(scaled, right[None], low * size, high * size).values[0] / size
    return step


def _distance(model: MorphableModel, before: FaceState, after: FaceState) -> float:
    """How far the placed vertices moved, rms, mm."""
    a, b = (s.T_target_model.apply(model.vertices(s.coefficients)) for s in (before, after))
    return float(np.sqrt(((a - b) ** 2).sum(axis=1).mean()))


@dataclass(frozen=True)
class ModelPoints:
    """Points that ride on the model, looked up once."""

    mean: Float[np.ndarray, "p 3"]
    modes: Float[np.ndarray, "p 3 k"]

    def placed(self, state: FaceState) -> Float[np.ndarray, "p 3"]:
        """Where they are in the target's frame, mm."""
        return state.T_target_model.apply(self.mean + self.modes @ state.coefficients)

    def jacobian(self, state: FaceState, placed: Float[np.ndarray, "p 3"]) -> Float[np.ndarray, "p 3 u"]:
        """How they move with the unknowns (the stand-off does not move them)."""
        p, T = len(placed), state.T_target_model
        turn = -skew(placed - T.translation)
        shift = np.broadcast_to(np.eye(3), (p, 3, 3))
        shapes = np.einsum("ab,pbk->pak", T.rotation, self.modes)
        return np.concatenate([turn, shift, shapes, np.zeros((p, 3, 1))], axis=2)


def points_at(model: MorphableModel, attachment: Attachment) -> ModelPoints:
    """Attached points of the model's surface."""
    corners = model.faces[attachment.faces]
    mean = np.einsum("pc,pcd->pd", attachment.barycentric, model.mean[corners])
    return ModelPoints(mean, np.einsum("pc,kpcd->pdk", attachment.barycentric, model.modes[:, corners]))


def vertices_at(model: MorphableModel, which: np.ndarray) -> ModelPoints:
    """Vertices of the model, by number or mask."""
    return ModelPoints(model.mean[which], np.ascontiguousarray(model.modes[:, which].transpose(1, 2, 0)))
