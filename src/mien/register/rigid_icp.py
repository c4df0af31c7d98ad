"""Rigid registration by surfaces: rounds of closest points (ICP), whatever finds and weighs them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, Literal, TypeVar

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..mesh import ClosestPoint, Mesh, vertex_normals
from ..transforms import Transform, rotation_from_vector, skew
from .correspond import Correspondences, Rejection, Surface
from .rigid import procrustes

REGULAR = 1e-9
"""Part of its diagonal added to a pose's system: a plane slides on itself, and leaves three of six directions open."""
State = TypeVar("State")


@dataclass(frozen=True)
class Rounds(Generic[State]):
    """Where rounds of closest points arrived."""

    state: State
    settled: bool
    """False where the rounds ran out first."""
    done: int


def closest_point_rounds(start: State, one_round: Callable[[State], tuple[State, bool]], most: int) -> Rounds[State]:
    """At most so many rounds, each from where the last one ended, until one says that it is the last."""
    state = start
    for done in range(1, most + 1):
        state, settled = one_round(state)
        if settled:
            return Rounds(state, True, done)
    return Rounds(state, False, max(most, 0))


@dataclass(frozen=True)
class PoseSystem:
    """Normal equations of a small turn about a centre (radians), a shift (mm), and what else is free, in this order."""

    A: Float[np.ndarray, "k k"]
    b: Float[np.ndarray, " k"]
    centre: Float[np.ndarray, " 3"]

    def __add__(self, other: "PoseSystem") -> "PoseSystem":
        return PoseSystem(self.A + other.A, self.b + other.b, self.centre)

    def held(self, values: Float[np.ndarray, " more"], weights: Float[np.ndarray, " more"]) -> "PoseSystem":
        """With what else is free, now at `values`, drawn to 0: sum weights (values + step)^2 is added."""
        A, b = self.A.copy(), self.b.copy()
        A[6:, 6:] += np.diag(weights)
        b[6:] -= weights * values
        return PoseSystem(A, b, self.centre)

    def solve(self) -> tuple[Transform, Float[np.ndarray, " more"]]:
        """The motion, and what else was free; directions that nothing holds do not move."""
        x = pose_step(self.A, self.b)
        R = rotation_from_vector(x[:3])
        return Transform(R, x[3:6] + self.centre - R @ self.centre), x[6:]


def pose_step(A: Float[np.ndarray, "k k"], b: Float[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
    """What solves a pose's system; radians and millimetres are made comparable by the system's diagonal."""
    size = np.sqrt(np.diag(A))
    size = np.where(size > 0, size, 1.0)
    return np.linalg.solve(A / np.outer(size, size) + REGULAR * np.eye(len(b)), b / size) / size


def weighted_centre(points: Float[np.ndarray, "n 3"], weights: Float[np.ndarray, " n"]) -> Float[np.ndarray, " 3"]:
    """About which points are turned."""
    return (weights[:, None] * points).sum(axis=0) / max(weights.sum(), 1e-300)


def plane_system(
    points: Float[np.ndarray, "n 3"],
    normals: Float[np.ndarray, "n 3"],
    off: Float[np.ndarray, " n"],
    weights: Float[np.ndarray, " n"],
    more: Float[np.ndarray, "n m"] | None = None,
) -> PoseSystem:
    """Points to planes (Chen and Medioni 1992): sum w (n . (T x - x) - off)^2, about the points' weighted centre.

    Args:
        off: how far each point must go along its normal, mm.
        more: what other unknowns move each point along its normal, a column each.
    """
    centre = weighted_centre(points, weights)
    columns = [np.cross(points - centre, normals), normals, *([] if more is None else [more])]
    rows = np.concatenate(columns, axis=1)
    return PoseSystem(rows.T @ (weights[:, None] * rows), rows.T @ (weights * off), centre)


def point_system(
    points: Float[np.ndarray, "n 3"],
    off: Float[np.ndarray, "n 3"],
    weights: Float[np.ndarray, " n"],
    centre: Float[np.ndarray, " 3"],
) -> PoseSystem:
    """Points to points: sum w |T x - x - off|^2, turned about `centre`."""
    turn = -skew(points - centre)
    rows = np.concatenate([turn, np.broadcast_to(np.eye(3), turn.shape)], axis=2)
    A = np.einsum("n,ndi,ndj->ij", weights, rows, rows)
    return PoseSystem(A, np.einsum("n,ndi,nd->i", weights, rows, off), centre)


@dataclass(frozen=True)
class IcpConfig:
    """How `icp` walks."""

    metric: Literal["plane", "point"] = "plane"
    """Distance to the target's tangent plane (fast on smooth surfaces) or to the closest point itself."""
    scale: bool = False
    """Also find a scale. Only from a close start and with a target that covers the source."""
    keep: float = 1.0
    """Share of the accepted points that count, nearest first (trimmed ICP); 1 keeps all."""
    robust: Literal["none", "huber", "tukey", "geman"] = "none"
    """Down-weighting of large residuals; their spread is measured anew each iteration (median)."""
    rejection: Rejection = field(default_factory=Rejection)
    """Which closest points are not believed."""
    iterations: int = 60
    """At most so many."""
    tolerance: float = 1e-4
    """Stop when no source point moves farther than this in one iteration, mm."""
    max_points: int = 20_000
    """Use at most so many source points, drawn at random with a fixed seed; 0 uses all."""


@dataclass(frozen=True)
class IcpResult:
    """Where `icp` arrived."""

    transform: Transform
    """T_target_source, the start included."""
    rms: float
    """Weighted root mean square distance of the points that counted, in the chosen metric, mm."""
    converged: bool
    """False where the iterations ran out first."""
    iterations: int
    weights: Float[np.ndarray, " n"]
    """How much each source point counted at the end; 0 = rejected, trimmed or not drawn."""


def icp(
    source: Float[np.ndarray, "n 3"] | Mesh,
    target: ClosestPoint,
    start: Transform | None = None,
    config: IcpConfig | None = None,
    normals: Float[np.ndarray, "n 3"] | None = None,
    weights: Float[np.ndarray, " n"] | None = None,
) -> IcpResult:
    """Iterative closest points: the rigid (or similarity) transform of `source` onto the surface of `target`.

    Point to point (Besl and McKay 1992) or point to plane (Chen and Medioni 1992), trimmed (Chetverikov 2002).
    A mesh brings its own normals for the rejection; bare points are tested by angle only if `normals` are given.
    Each point counts by its `weights`, if given; those of weight 0 are not looked at.

    Raises:
        BadInput: fewer than three points find a believable closest point.
    """
    config = config or IcpConfig()
    if isinstance(source, Mesh):
        normals = vertex_normals(source.vertices, source.faces) if normals is None else normals
        source = source.vertices
    counted = np.arange(len(source)) if weights is None else np.flatnonzero(weights > 0)
    drawn = counted[_draw(len(counted), config.max_points)]
    prior = np.ones(len(drawn)) if weights is None else weights[drawn]
    points, n = source[drawn], None if normals is None else normals[drawn]
    surface = Surface(target)

    def one_round(T: Transform) -> tuple[Transform, bool]:
        moved = T.apply(points)
        pairs, w = _pairs(surface, moved, None if n is None else T.rotate(n), prior, config)
        step = _step(moved, pairs, w, config)
        still = np.linalg.norm(step.apply(moved) - moved, axis=1).max() < config.tolerance
        return step @ T, bool(still)

    walked = closest_point_rounds(start or Transform.identity(), one_round, config.iterations)
    transform = walked.state
    moved = transform.apply(points)
    pairs, w = _pairs(surface, moved, None if n is None else transform.rotate(n), prior, config)
    final = np.zeros(len(source))
    final[drawn] = w
    rms = float(np.sqrt((w * _distances(moved, pairs, config) ** 2).sum() / w.sum()))
    return IcpResult(transform, rms, walked.settled, walked.done, final)


def _draw(n: int, most: int) -> np.ndarray:
    if not most or n <= most:
        return np.arange(n)
    return np.sort(np.random.default_rng(0).choice(n, most, replace=False))


def _distances(moved: np.ndarray, pairs: Correspondences, config: IcpConfig) -> np.ndarray:
    if config.metric == "point":
        return pairs.distances
    return np.abs(np.einsum("nd,nd->n", moved - pairs.points, pairs.normals))


def _pairs(
    surface: Surface, moved: np.ndarray, normals: np.ndarray | None, prior: np.ndarray, config: IcpConfig
) -> tuple[Correspondences, np.ndarray]:
    """Correspondences and their weights after rejection, trimming and down-weighting."""
    pairs = surface.correspond(moved, normals, config.rejection)
    w = prior * pairs.accepted
    if (w > 0).sum() < 3:
        raise BadInput(
            f"icp: {int((w > 0).sum())} of {len(w)} points have a believable closest point on the target; "
            "start closer or loosen the rejection"
        )
    if config.keep < 1:
        w[pairs.distances > np.quantile(pairs.distances[pairs.accepted], config.keep)] = 0
    if config.robust != "none":
        w *= _robust_weights(_distances(moved, pairs, config), w, config.robust)
    return pairs, w


def _robust_weights(distances: np.ndarray, counted: np.ndarray, kind: str) -> np.ndarray:
    """Weights of iteratively reweighted least squares, the spread taken from the median of what counted, as it did."""
    spread = max(1.4826 * _weighted_median(distances, counted), 1e-9)
    if kind == "huber":
        return np.minimum(1.0, 1.345 * spread / np.maximum(distances, 1e-12))
    if kind == "geman":
        return 1 / (1 + (distances / spread) ** 2) ** 2
    return np.maximum(1 - (distances / (4.685 * spread)) ** 2, 0) ** 2


def _weighted_median(values: np.ndarray, weights: np.ndarray) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, total[-1] / 2)]])


def _step(moved: np.ndarray, pairs: Correspondences, w: np.ndarray, config: IcpConfig) -> Transform:
    """One step: point to point in closed form, point to plane by Gauss and Newton, with a scale where it is free."""
    if config.metric == "point":
        return procrustes(moved, pairs.points, w, scale=config.scale).transform
    off = np.einsum("nd,nd->n", pairs.points - moved, pairs.normals)
    centre = weighted_centre(moved, w)
    growth = np.einsum("nd,nd->n", moved - centre, pairs.normals)[:, None]
    motion, more = plane_system(moved, pairs.normals, off, w, growth if config.scale else None).solve()
    if not config.scale:
        return motion
    size = 1 + float(more[0])
    shift = motion.apply(centre[None])[0]
    return Transform(motion.rotation, shift - size * motion.rotation @ centre, size)
