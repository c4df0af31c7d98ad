"""Fill what the cameras missed: short gaps along time, middling ones across markers; long ones stay open."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline

from ..clip import visible


@dataclass(frozen=True)
class GapConfig:
    """How long a gap may be to be filled, and how."""

    spline_s: float = 0.1
    """Seconds. Gaps up to this long are bridged by a cubic spline within the marker; 0 switches it off."""
    low_rank_s: float = 0.5
    """Seconds. Longer gaps up to this are filled from the other markers; inf fills all, 0 switches it off."""
    rank: int = 12
    """Principal components of the take that carry the fill across markers."""
    sweeps: int = 20
    """Rounds of fill and principal components."""


def fill_gaps(
    positions: Float[np.ndarray, "frames markers 3"], rate: float, config: GapConfig = GapConfig()
) -> Float[np.ndarray, "frames markers 3"]:
    """Positions in the head's frame (mm, NaN = gap) with short and middling gaps filled; `rate` in frames a second.

    Frames in which nothing at all was seen are never filled. The low-rank fill is the iterated principal-component
    regression of Liu and McMillan (2006): the take's own statistics say where a hidden marker must be.
    """
    seen = visible(positions)
    filled = positions.copy()
    length = gap_lengths(seen) / rate
    alive = np.asarray(seen.any(axis=1))[:, None]
    for marker in np.flatnonzero((~seen).any(axis=0) & (seen.sum(axis=0) >= 4)):
        wanted = ~seen[:, marker] & (length[:, marker] <= config.spline_s) & alive[:, 0] & _inside(seen[:, marker])
        if wanted.any():
            here = np.flatnonzero(seen[:, marker])
            filled[wanted, marker] = CubicSpline(here, positions[here, marker])(np.flatnonzero(wanted))
    still = ~visible(filled)
    wanted = still & (length <= config.low_rank_s) & alive & seen.any(axis=0)
    if wanted.any():
        estimate = _low_rank(filled, alive[:, 0], config)
        filled[wanted] = estimate[wanted]
    return filled


def gap_lengths(seen: Bool[np.ndarray, "frames markers"]) -> Float[np.ndarray, "frames markers"]:
    """For every missing sample the number of frames of the gap it lies in; 0 where the marker was seen."""
    lengths = np.zeros(seen.shape)
    for marker in np.flatnonzero((~seen).any(axis=0)):
        edges = np.flatnonzero(np.diff(np.r_[False, ~seen[:, marker], False]))
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            lengths[start:end, marker] = end - start
    return lengths


def _inside(seen: np.ndarray) -> np.ndarray:
    """Frames between the first and the last sighting: a spline must not run beyond its ends."""
    first, last = np.flatnonzero(seen)[[0, -1]]
    frames = np.arange(len(seen))
    return (frames > first) & (frames < last)


def _low_rank(positions: np.ndarray, alive: np.ndarray, config: GapConfig) -> np.ndarray:
    """Every sample as the take's leading principal components have it, fitted to what was seen."""
    t, m, _ = positions.shape
    X = positions[alive].reshape(-1, 3 * m)
    seen = np.isfinite(X)
    mean = np.nanmean(np.where(seen.any(axis=0), X, 0.0), axis=0)
    X = np.where(seen, X, mean)
    rank = max(1, min(config.rank, min(X.shape) - 1))
    basis = np.random.default_rng(0).normal(size=(3 * m, rank))
    for _ in range(config.sweeps):
        mean = X.mean(axis=0)
        for _ in range(2):
            basis = np.linalg.qr((X - mean).T @ ((X - mean) @ basis))[0]
        X = np.where(seen, X, mean + (X - mean) @ basis @ basis.T)
    estimate = np.full((t, 3 * m), np.nan)
    estimate[alive] = X
    return estimate.reshape(t, m, 3)
