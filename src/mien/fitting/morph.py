"""Fitting a linear face model (who, and what expression) to landmarks and a surface that is trusted more and more."""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int

from ..mesh import mass, vertex_normals
from ..register.correspond import Rejection, Surface
from ..register.nonrigid import Anchors
from ..solve import box_least_squares
from ..transforms import Transform, rotation_from_vector


@dataclass(frozen=True)
class LinearModel:
    """x = mean + sum_k c_k modes_k, each c_k normal about `expected` with deviation `spread`, within bounds."""

    mean: Float[np.ndarray, "n 3"]
    """Millimetres."""
    faces: Int[np.ndarray, "m 3"]
    modes: Float[np.ndarray, "k n 3"]
    expected: Float[np.ndarray, " k"]
    spread: Float[np.ndarray, " k"]
    lower: Float[np.ndarray, " k"]
    """-inf where there is no bound."""
    upper: Float[np.ndarray, " k"]

    def vertices(self, coefficients: Float[np.ndarray, " k"]) -> Float[np.ndarray, "n 3"]:
        """The shape."""
        return self.mean + np.tensordot(coefficients, self.modes, axes=1)


@dataclass(frozen=True)
class MorphConfig:
    """How a model is fitted. Lengths in mm."""

    landmark_sigma: float = 2.0
    """How wrong a landmark is expected to be."""
    surface_sigma: tuple[float, ...] = (8.0, 4.0, 2.0, 1.2, 0.8)
    """How far the surface is expected to be from the model, round by round: it begins to count late."""
    rounds: int = 3
    """Gauss-Newton steps at each of `surface_sigma`."""
    samples: float = 400.0
    """The surface counts as so many independent measurements, since neighbouring vertices err alike."""
    rejection: Rejection = field(default_factory=lambda: Rejection(max_distance=15.0, max_angle_deg=50.0))
    """Which closest points count; beyond three times the round's sigma they fade."""


@dataclass(frozen=True)
class MorphResult:
    """A fitted model."""

    coefficients: Float[np.ndarray, " k"]
    vertices: Float[np.ndarray, "n 3"]
    """The model's shape, in its own frame."""
    T_model_target: Transform
    """Rigid: brings the target onto the model."""
    landmark_rms: float
    """Millimetres."""
    surface_median: float
    """Median distance of the vertices that counted, mm."""
    converged: bool
    """Whether the last step moved the vertices by less than 0.05 mm rms."""


def fit_model(
    model: LinearModel,
    target: Surface,
    anchors: Anchors,
    trust: Float[np.ndarray, " n"],
    config: MorphConfig | None = None,
    start: MorphResult | None = None,
) -> MorphResult:
    """Pose and coefficients that bring the model onto `target` (aligned with it but for a few centimetres and degrees).

    Maximum a posteriori by Gauss-Newton: landmarks, distances across the surface, the coefficients' priors and bounds.

    Args:
        anchors: landmarks on the model (`attachment` in its topology) and their places on the target, mm.
        trust: weight of each vertex's closest point; 0 where the target has no such surface.
        start: an earlier fit to go on from.
    """
    config = config or MorphConfig()
    fit = _Fit(model, target, anchors, trust, config)
    c, T = model.expected.copy(), Transform.identity()
    if start is not None:
        c, T = np.clip(start.coefficients, model.lower, model.upper), start.T_model_target.inverse()
    moved = np.inf
    for sigma in np.repeat(config.surface_sigma, config.rounds):
        c, T, moved = fit.step(c, T, float(sigma))
    x = model.vertices(c)
    placed = T.apply(x)
    pairs = target.correspond(placed[fit.used], vertex_normals(placed, model.faces)[fit.used], config.rejection)
    rest = np.linalg.norm(fit.D @ placed - anchors.points, axis=1)[anchors.weights > 0]
    near = pairs.distances[pairs.accepted]
    return MorphResult(
        coefficients=c,
        vertices=x,
        T_model_target=T.inverse(),
        landmark_rms=float(np.sqrt((rest**2).mean())) if len(rest) else float("nan"),
        surface_median=float(np.median(near)) if len(near) else float("nan"),
        converged=moved < 0.05,
    )


class _Fit:
    """What stays the same from step to step."""

    def __init__(self, model: LinearModel, target: Surface, anchors: Anchors, trust: np.ndarray, config: MorphConfig):
        self.model, self.target, self.anchors, self.config = model, target, anchors, config
        self.used: Bool[np.ndarray, " n"] = trust > 0
        area = mass(model.mean, model.faces)[self.used] * trust[self.used]
        self.share = config.samples * area / area.sum()
        corners = anchors.attachment.faces
        weights = anchors.attachment.barycentric
        rows = np.repeat(np.arange(len(corners)), 3)
        self.D = sp.csr_matrix((weights.ravel(), (rows, model.faces[corners].ravel())), (len(corners), len(model.mean)))
        k = len(model.modes)
        flat = model.modes.transpose(1, 2, 0).reshape(len(model.mean), 3 * k)
        self.landmark_modes = (self.D @ flat).reshape(-1, 3, k)
        self.modes = flat.reshape(-1, 3, k)[self.used]

    def step(self, c: np.ndarray, T: Transform, sigma: float) -> tuple[np.ndarray, Transform, float]:
        """One Gauss-Newton step over pose (rotation vector, translation) and coefficients."""
        model = self.model
        x = model.vertices(c)
        gram, linear = self._landmarks(x, T)
        more = self._surface(x, T, sigma)
        gram, linear = gram + more[0], linear + more[1]
        k = len(c)
        prior = 1 / model.spread**2
        gram[6:, 6:] += np.diag(prior)
        linear[6:] += prior * (model.expected - c)
        gram[:6, :6] += 1e-9 * np.trace(gram[:6, :6]) * np.eye(6)
        low, high = np.r_[np.full(6, -np.inf), model.lower - c], np.r_[np.full(6, np.inf), model.upper - c]
        size = np.sqrt(np.diag(gram))
        scaled = gram / np.outer(size, size)
        solved = box_least_squares(scaled, (linear / size)[None], low * size, high * size).values[0] / size
        turn = rotation_from_vector(solved[:3])
        fresh = Transform(turn @ T.rotation, T.translation + solved[3:6])
        new = np.clip(c + solved[6 : 6 + k], model.lower, model.upper)
        moved = float(np.sqrt(((fresh.apply(model.vertices(new)) - T.apply(x))[self.used] ** 2).sum(axis=1).mean()))
        return new, fresh, moved

    def _landmarks(self, x: np.ndarray, T: Transform) -> tuple[np.ndarray, np.ndarray]:
        turned = (self.D @ x) @ T.rotation.T
        rest = self.anchors.points - turned - T.translation
        size = np.linalg.norm(rest, axis=1)
        scale = 2.5 * self.config.landmark_sigma
        weights = self.anchors.weights / (1 + (size / scale) ** 2) ** 2 / self.config.landmark_sigma**2
        J = np.concatenate([_turns(turned), np.tile(np.eye(3), (len(rest), 1, 1))], axis=2)
        J = np.concatenate([J, np.einsum("ab,pbk->pak", T.rotation, self.landmark_modes)], axis=2)
        J, r, w = J.reshape(-1, J.shape[2]), rest.ravel(), np.repeat(weights, 3)
        return J.T @ (w[:, None] * J), J.T @ (w * r)

    def _surface(self, x: np.ndarray, T: Transform, sigma: float) -> tuple[np.ndarray, np.ndarray]:
        placed = T.apply(x)
        normals = vertex_normals(placed, self.model.faces)[self.used]
        placed = placed[self.used]
        pairs = self.target.correspond(placed, normals, self.config.rejection)
        rest = np.einsum("nd,nd->n", pairs.points - placed, pairs.normals)
        fade = 1 / (1 + (pairs.distances / (3 * sigma)) ** 2) ** 2
        w = self.share * pairs.accepted * fade / sigma**2
        turned = placed - T.translation
        back = pairs.normals @ T.rotation
        across = np.einsum("nb,nbk->nk", back, self.modes)
        J = np.concatenate([np.cross(turned, pairs.normals), pairs.normals, across], axis=1)
        return J.T @ (w[:, None] * J), J.T @ (w * rest)


def _turns(points: np.ndarray) -> np.ndarray:
    """d(rotation_from_vector(r) @ p) / dr at r = 0: (p, 3, 3)."""
    x, y, z = points.T
    o = np.zeros_like(x)
    return np.stack([np.stack([o, z, -y], 1), np.stack([-z, o, x], 1), np.stack([y, -x, o], 1)], 1)
