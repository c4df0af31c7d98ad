"""Wild samples, ghosts and swapped labels, found sample by sample before anything is aligned by them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ..clip import Markers, visible
from ..one_line import count
from .stabilise import StabiliseConfig, stabilise


@dataclass(frozen=True)
class OutlierConfig:
    """What counts as a sample that cannot be."""

    times: float = 8.0
    """A sample is wild this many times its marker's usual distance from where its neighbours say; inf: never."""
    least_mm: float = 8.0
    """... and at least this far, mm."""
    of_spacing: float = 0.3
    """... and at least this share of the distance to the nearest marker: sparse markers are told less well."""
    sudden: float = 0.5
    """A run of wild samples must begin or end with a step of this share of its farthest: skin that moves fast takes
    several frames, a ghost or a swapped label one. 0: any run counts."""
    impossible_mm: float = 40.0
    """... unless it goes this far, mm: no skin does, beside its neighbours; a marker that slips off creeps there."""
    neighbours: int = 8
    """Markers that predict another."""
    rounds: int = 16
    """At most so many; each finds the worst sample of every neighbourhood, and what it pulled at is judged anew in the
    next: of markers that are off together, those inside come out after those at the rim."""
    fit_rounds: int = 3
    """Robust rounds of one prediction."""
    ridge_mm2: float = 20.0
    """Holds a prediction back where neighbours hardly move, mm^2."""
    most_frames: int = 1500
    """Frames that a prediction is learnt from, spread over the take."""


@dataclass(frozen=True)
class Cleaned:
    """A take without its wild samples."""

    markers: Markers
    """Wild samples are gaps."""
    wild: Bool[np.ndarray, "frames markers"]
    """Which they are."""

    def line(self) -> str:
        """What was found, in one line; empty where nothing was."""
        counts = self.wild.sum(axis=0)
        worst = [i for i in np.argsort(-counts, kind="stable")[:_NAMED] if counts[i]]
        if not worst:
            return ""
        first = {i: int(np.argmax(self.wild[:, i])) for i in worst}
        named = ", ".join(f"{self.markers.labels[i]} ({counts[i]} from frame {first[i]})" for i in worst)
        more = f" and {int((counts > 0).sum()) - len(worst)} more markers" if (counts > 0).sum() > len(worst) else ""
        wild = count(int(counts.sum()), "samples")
        return f"treated as gaps: {wild} gone wild (ghosts, swapped labels): {named}{more}"


_NAMED = 4
"""Markers that the line names."""


def remove_outliers(markers: Markers, config: OutlierConfig = OutlierConfig()) -> Cleaned:
    """Turn samples into gaps that lie far from where their neighbours on the skin say.

    Every marker's motion in the head's frame is predicted from its nearest neighbours' by robust regression over the
    take, so that a marker that moves much (a jaw that opens) is judged by how well it can be told, not by how far it
    goes. Of samples that disagree with one another in one frame the worst goes first.
    """
    wild = np.zeros(markers.seen.shape, dtype=bool)
    if not np.isfinite(config.times) or markers.seen.any(axis=0).sum() < 3 or not (markers.seen.sum(axis=1) >= 3).any():
        return Cleaned(markers, wild)
    head = stabilise(markers, StabiliseConfig()).markers.positions
    neighbours = nearest_markers(head, config.neighbours)
    spacing = _spacing(head, neighbours)
    first = prediction_error(head, neighbours, config)
    for _ in range(config.rounds):
        rest = np.where(wild[..., None], np.nan, head)
        off = prediction_error(rest, neighbours, config) if wild.any() else first
        worst = off / np.maximum(_threshold(off, config), config.of_spacing * spacing)
        around = worst[:, neighbours].max(axis=2)
        found = (worst > 1) & (worst >= around)
        if not found.any():
            break
        wild |= found
    wild &= sudden_runs(wild, first, markers.seen, config)
    return Cleaned(markers.with_positions(np.where(wild[..., None], np.nan, markers.positions)), wild)


def sudden_runs(
    wild: Bool[np.ndarray, "frames markers"],
    off: Float[np.ndarray, "frames markers"],
    seen: Bool[np.ndarray, "frames markers"],
    config: OutlierConfig,
) -> Bool[np.ndarray, "frames markers"]:
    """Samples of runs that begin or end with a step, at a gap or at an end of the take, or go where no skin does."""
    kept = np.zeros_like(wild)
    for i in np.flatnonzero(wild.any(axis=0)):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], wild[:, i], [False]]).astype(int)))
        for begin, end in edges.reshape(-1, 2):
            farthest = off[begin:end, i].max()
            open_ends = begin == 0 or end == len(wild) or not (seen[begin - 1, i] and seen[end, i])
            step = 0.0 if open_ends else max(off[begin, i] - off[begin - 1, i], off[end - 1, i] - off[end, i])
            kept[begin:end, i] = open_ends or step >= config.sudden * farthest or farthest > config.impossible_mm
    return kept


def nearest_markers(head: Float[np.ndarray, "frames markers 3"], count: int) -> Int[np.ndarray, "markers k"]:
    """For every marker the `count` nearest others, by their median places; markers never seen come last."""
    place = np.nan_to_num(_median(head), nan=1e6)
    apart = np.linalg.norm(place[:, None] - place[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    return np.argsort(apart, axis=1, kind="stable")[:, : min(count, len(place) - 1)]


def _spacing(head: np.ndarray, neighbours: np.ndarray) -> np.ndarray:
    """Middle distance from each marker to its nearest, mm."""
    place = _median(head)
    return np.nan_to_num(np.linalg.norm(place - place[neighbours[:, 0]], axis=1))


def prediction_error(
    head: Float[np.ndarray, "frames markers 3"], neighbours: Int[np.ndarray, "markers k"], config: OutlierConfig
) -> Float[np.ndarray, "frames markers"]:
    """How far each sample lies from what its neighbours predict, mm; 0 where it was not seen."""
    frames = np.unique(np.linspace(0, len(head) - 1, min(len(head), config.most_frames)).astype(int))
    moved = head - _median(head)
    seen, known = visible(moved), np.nan_to_num(moved)
    off, trust = np.zeros(seen.shape), _first_trust(known, config)
    for i, around in enumerate(neighbours):
        A = known[:, around].reshape(len(head), -1)
        learn = frames[seen[frames, i]]
        if len(learn) < 3:
            continue
        B = _robust_fit(A[learn], known[learn, i], trust[learn, i] * trust[learn][:, around].min(axis=1), config)
        left = np.linalg.norm(known[:, i] - A @ B[:-1] - B[-1], axis=1)
        off[:, i] = np.where(seen[:, i], left, 0.0)
    return off


def _first_trust(moved: np.ndarray, config: OutlierConfig) -> np.ndarray:
    """How little each sample stands out of its own marker's path, (frames, markers) in 0..1.

    Without it two markers that wear each other's label for long would predict each other.
    """
    size = np.linalg.norm(moved, axis=2)
    scale = config.times * np.median(size, axis=0) + config.least_mm / 2
    return 1 / (1 + (size / scale) ** 2) ** 2


def _robust_fit(A: np.ndarray, y: np.ndarray, weight: np.ndarray, config: OutlierConfig) -> np.ndarray:
    """Ridge regression with a constant, samples losing weight as they fit worse (Geman and McClure's): (k + 1, 3)."""
    A = np.c_[A, np.ones(len(A))]
    ridge = config.ridge_mm2 * np.eye(A.shape[1])
    B, first = np.zeros((A.shape[1], 3)), weight
    for _ in range(config.fit_rounds):
        AW = A * weight[:, None]
        B = np.linalg.solve(A.T @ AW + ridge, AW.T @ y)
        left = np.linalg.norm(y - A @ B, axis=1)
        scale = max(3.0 * float(np.median(left)), config.least_mm / 5)
        weight = first / (1 + (left / scale) ** 2) ** 2
    return B


def _threshold(off: np.ndarray, config: OutlierConfig) -> np.ndarray:
    """How far a sample of each marker may be off, mm."""
    usual = np.array([np.median(o[o > 0]) if (o > 0).any() else 0.0 for o in off.T])
    return np.maximum(config.times * usual, config.least_mm)


def _median(values: np.ndarray) -> np.ndarray:
    empty = ~np.isfinite(values).any(axis=0)
    return np.where(empty, np.nan, np.nanmedian(np.where(empty, 0.0, values), axis=0))
