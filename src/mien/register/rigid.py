"""Rigid and similarity registration by corresponding points (Procrustes)."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ..transforms import Transform


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


def procrustes_robust(
    source: Float[np.ndarray, "n 3"],
    target: Float[np.ndarray, "n 3"],
    scales: Iterable[float],
    weights: Float[np.ndarray, " n"] | None = None,
) -> ProcrustesResult:
    """`procrustes` in which points that lie far off lose weight (Geman and McClure), rigid only.

    Args:
        scales: a round each: a point that is off by so much counts a quarter in the next one, mm.

    Raises:
        ValueError: as `procrustes`, or no scale.
    """
    share = np.ones(len(source)) if weights is None else weights
    believed, found = share, None
    for scale in scales:
        found = procrustes(source, target, believed)
        believed = share / (1 + (np.nan_to_num(found.residuals) / scale) ** 2) ** 2
    if found is None:
        raise ValueError("scales: expected at least one, got none")
    return found


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
