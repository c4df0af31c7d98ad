"""Which markers of a take can be spared: the study that Huang et al. 2011 leave as future work."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ...errors import BadInput
from ...progress import SILENT, Progress
from ...solve import nnls


@dataclass(frozen=True)
class StudyConfig:
    """How far and how finely markers are taken away."""

    least: int = 12
    """Markers at which to stop; a third of the chosen frames at least, as fewer do not determine the weights."""
    sample: int = 200
    """Frames, evenly spaced, on which candidates are compared; the error curve is over all frames."""


@dataclass(frozen=True)
class MarkerStudy:
    """Markers in the order in which they can best be spared."""

    removed: Int[np.ndarray, " removed"]
    """Markers taken away, first to last."""
    errors: Float[np.ndarray, " removed_and_one"]
    """Mean distance of all markers from their places, mm, with 0, 1, 2, ... markers taken away."""
    markers: int
    """How many there are in all."""

    def keep(self, count: int) -> Int[np.ndarray, " count"]:
        """The `count` markers to keep, ascending.

        Raises:
            BadInput: the study did not go so far, or there are not so many.
        """
        fewest = self.markers - len(self.removed)
        if not fewest <= count <= self.markers:
            raise BadInput(f"{count} markers asked for; the study covers {fewest} to {self.markers}")
        return np.setdiff1d(np.arange(self.markers), self.removed[: self.markers - count])


def select_markers(
    positions: Float[np.ndarray, "frames markers 3"],
    chosen: Int[np.ndarray, " chosen"],
    config: StudyConfig = StudyConfig(),
    progress: Progress = SILENT,
) -> MarkerStudy:
    """Take markers away one at a time, always the one without which the rest still tell most of the whole face.

    For a set of markers the weights of every frame are found from that set alone (non-negative least squares on the
    `chosen` frames, as the selection and the reconstruction do), and judged by the squared distances of all markers.
    Greedy and backward: each step tries every marker that is left.

    Args:
        positions: markers in the head's frame, mm, gaps filled.
        chosen: frames that serve as bases, such as `select_frames` gives.

    Raises:
        BadInput: gaps are left, or there are fewer markers than the study would keep.
    """
    markers = positions.shape[1]
    least = max(config.least, -(-len(chosen) // 3))
    if not np.isfinite(positions).all():
        raise BadInput("positions have gaps; fill them or leave out the markers before the study")
    if markers <= least:
        raise BadInput(f"{markers} markers, of which the study would keep {least}: nothing to take away")
    X = positions - positions.mean(axis=(0, 1))
    basis = X[chosen]
    sample = np.linspace(0, len(X) - 1, min(config.sample, len(X))).astype(int)
    grams = np.einsum("amd,bmd->mab", basis, basis)
    linears = np.einsum("tmd,bmd->mtb", X[sample], basis)
    whole_gram, whole_linear = grams.sum(axis=0), linears.sum(axis=0)
    gram, linear, kept = whole_gram, whole_linear, list(range(markers))
    removed, errors = [], [_mean_error(X, basis, kept)]
    warm = nnls(gram, linear).values
    for step in range(markers - least):
        progress.update("taking markers away", step, markers - least)
        tried = [nnls(gram - grams[m], linear - linears[m], warm=warm).values for m in kept]
        costs = [np.vdot(w @ whole_gram, w) - 2 * np.vdot(w, whole_linear) for w in tried]
        best = int(np.argmin(costs))
        warm, marker = tried[best], kept.pop(best)
        gram, linear = gram - grams[marker], linear - linears[marker]
        removed.append(marker)
        errors.append(_mean_error(X, basis, kept))
    progress.update("taking markers away", markers - least, markers - least)
    return MarkerStudy(np.array(removed), np.array(errors), markers)


def _mean_error(X, basis, kept):
    """Mean distance of all markers when the weights come from the kept ones."""
    seen = basis[:, kept].reshape(len(basis), -1)
    weights = nnls(seen @ seen.T, X[:, kept].reshape(len(X), -1) @ seen.T).values
    return float(np.linalg.norm(X - np.einsum("tb,bmd->tmd", weights, basis), axis=2).mean())
