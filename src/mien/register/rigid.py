"""Rigid and similarity registration: by corresponding points (Procrustes) and by surfaces (ICP)."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from ..errors import BadInput
from ..mesh import ClosestPoint, Mesh, vertex_normals
from ..transforms import Transform, rotation_from_vector
from .correspond import Correspondences, Rejection, Surface


@dataclass(frozen=True)
class ProcrustesResult:
    """The best transform between corresponding points, one or one a frame."""

    transform: Transform
    """T_target_source."""
    residuals: Float[np.ndarray, "*batch n"]
    """Distance that remains at each point, mm; NaN where a point was missing."""
    rms: Float[np.ndarray, "*batch"] | float
    """Weighted root mean square of the residuals, mm."""
    determined: Bool[np.ndarray, "*batch"] | bool
    """False where the points do not fix the rotation (fewer than three, or on one line): then the smallest one."""


def procrustes(
    source: Float[np.ndarray, "n 3"],
    target: Float[np.ndarray, "m 3"],
    weights: Float[np.ndarray, " n"] | None = None,
    scale: bool = False,
) -> ProcrustesResult:
    """The rigid transform (similarity with `scale`) that takes `source` closest to `target`, in least squares.

    Never a reflection. m = n. Points with NaN or zero weight are left out (Umeyama 1991).

    Raises:
        ValueError: shapes differ, a weight is negative, or no point is left.
    """
    if source.shape != target.shape:
        raise ValueError(f"source, target: expected one shape, got {source.shape} and {target.shape}")
    w = _weights(source[None], target[None], None if weights is None else weights[None])
    if not w.sum():
        raise ValueError("source, target: no point is present in both with a weight")
    s, t = np.nan_to_num(source)[None], np.nan_to_num(target)[None]
    s_mean, t_mean, H = _moments(s, t, w)
    R, singular, determined = nearest_rotations(H)
    variance = float((w[0] * ((s[0] - s_mean[0]) ** 2).sum(axis=1)).sum())
    size = float(singular[0].sum() / variance) if scale and variance > 0 else 1.0
    transform = Transform(R[0], t_mean[0] - size * R[0] @ s_mean[0], size)
    residuals, rms = _residuals(transform.apply(s[0])[None], t, w)
    return ProcrustesResult(transform, residuals[0], float(rms[0]), bool(determined[0]))


def procrustes_frames(
    source: Float[np.ndarray, "..."],
    target: Float[np.ndarray, "frames n 3"],
    weights: Float[np.ndarray, "..."] | None = None,
) -> ProcrustesResult:
    """`procrustes` frame by frame, all at once: source (n, 3) or (t, n, 3), weights (n,) or (t, n); rigid only.

    NaN points and zero weights are left out of their frame. A frame with no point left gets the identity,
    an rms of NaN and `determined` False.

    Raises:
        ValueError: shapes that do not fit, or a negative weight.
    """
    if source.shape not in (target.shape, target.shape[1:]):
        raise ValueError(f"source: expected {target.shape[1:]} or {target.shape}, got {source.shape}")
    s = np.broadcast_to(source, target.shape)
    w = _weights(s, target, None if weights is None else np.broadcast_to(weights, target.shape[:2]))
    s, t = np.nan_to_num(s), np.nan_to_num(target)
    s_mean, t_mean, H = _moments(s, t, w)
    R, _, determined = nearest_rotations(H)
    transform = Transform(R, t_mean - np.einsum("tij,tj->ti", R, s_mean))
    residuals, rms = _residuals(transform.apply(s), t, w)
    return ProcrustesResult(transform, residuals, rms, determined)


def _weights(source: np.ndarray, target: np.ndarray, weights: np.ndarray | None) -> np.ndarray:
    """(t, n) weights that are zero wherever something is missing."""
    present = np.isfinite(source).all(axis=2) & np.isfinite(target).all(axis=2)
    w = np.ones(present.shape) if weights is None else np.nan_to_num(weights.astype(float))
    if (w < 0).any():
        raise ValueError(f"weights: expected none below 0, got {w.min()}")
    return w * present


def _moments(s: np.ndarray, t: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weighted means and the covariance H = sum w (t - t_mean)(s - s_mean)^T, per frame."""
    total = np.maximum(w.sum(axis=1), 1e-300)[:, None]
    s_mean = np.einsum("tn,tnd->td", w, s) / total
    t_mean = np.einsum("tn,tnd->td", w, t) / total
    H = np.einsum("tn,tni,tnj->tij", w, t - t_mean[:, None], s - s_mean[:, None], optimize=True)
    return s_mean, t_mean, H


def nearest_rotations(H: Float[np.ndarray, "t 3 3"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Proper rotations R that maximise trace(R^T H), signed singular values (t, 3), and where R is unique (t,).

    Where H has rank below 2 the maximisers are many: a whisper of identity picks the smallest rotation.
    """
    U, singular, Vt = np.linalg.svd(H)
    determined = singular[:, 1] > 1e-9 * np.maximum(singular[:, 0], 1e-300)
    loose = ~determined
    if loose.any():
        whisper = np.maximum(1e-8 * singular[loose, 0], 1e-300)
        U[loose], singular[loose], Vt[loose] = np.linalg.svd(H[loose] + whisper[:, None, None] * np.eye(3))
    sign = np.where(np.linalg.det(U @ Vt) < 0, -1.0, 1.0)
    U[:, :, 2] *= sign[:, None]
    singular[:, 2] *= sign
    return U @ Vt, singular, determined


def _residuals(moved: np.ndarray, t: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    squared = ((moved - t) ** 2).sum(axis=2)
    total = w.sum(axis=1)
    rms = np.sqrt((w * squared).sum(axis=1) / np.where(total > 0, total, np.nan))
    return np.where(w > 0, np.sqrt(squared), np.nan), rms


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
    transform, converged, done = start or Transform.identity(), False, 0
    while done < config.iterations and not converged:
        done += 1
        moved = transform.apply(points)
        pairs, w = _pairs(surface, moved, None if n is None else transform.rotate(n), prior, config)
        if config.metric == "plane":
            step = _plane_step(moved, pairs, w, config.scale)
        else:
            step = procrustes(moved, pairs.points, w, scale=config.scale).transform
        transform = step @ transform
        converged = bool(np.linalg.norm(step.apply(moved) - moved, axis=1).max() < config.tolerance)
    moved = transform.apply(points)
    pairs, w = _pairs(surface, moved, None if n is None else transform.rotate(n), prior, config)
    final = np.zeros(len(source))
    final[drawn] = w
    rms = float(np.sqrt((w * _distances(moved, pairs, config) ** 2).sum() / w.sum()))
    return IcpResult(transform, rms, converged, done, final)


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


def _plane_step(moved: np.ndarray, pairs: Correspondences, w: np.ndarray, scale: bool) -> Transform:
    """One Gauss-Newton step of sum w (n . (T x - y))^2 about the weighted centre, sizes made comparable.

    Directions that the planes leave open (a plane slides on itself) do not move.
    """
    centre = (w[:, None] * moved).sum(axis=0) / w.sum()
    p = moved - centre
    radius = max(float(np.sqrt((w * (p**2).sum(axis=1)).sum() / w.sum())), 1e-12)
    columns = [np.cross(p, pairs.normals) / radius, pairs.normals]
    if scale:
        columns.append(np.einsum("nd,nd->n", p, pairs.normals)[:, None] / radius)
    A = np.concatenate(columns, axis=1)
    b = np.einsum("nd,nd->n", pairs.points - moved, pairs.normals)
    N = A.T @ (w[:, None] * A)
    x = np.linalg.pinv(N, rcond=1e-10, hermitian=True) @ (A.T @ (w * b))
    R = rotation_from_vector(x[:3] / radius)
    size = 1 + x[6] / radius if scale else 1.0
    return Transform(R, x[3:6] + centre - size * R @ centre, float(size))
