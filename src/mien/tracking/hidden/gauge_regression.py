"""Shapes of a hidden upper face from further channels: a ridge regression learnt where both were seen."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...io.gauge_file import GaugeTable
from ...rig import Performance
from .lower_face import upper_shapes

SHORTEST_S = 5.0
"""A calibration's least length, seconds, in which face and gauges were both seen."""
PENALTIES = tuple(10.0**power for power in range(-1, 4))
"""Ridge penalties that are tried, in frames: the channels are counted in their standard deviations."""
FOLDS, STRETCH_S = 5, 2.0
"""Parts of the calibration that are left out in turn, to choose the penalty and to tell the error; each is made of
stretches so long, seconds, from all over it."""
WINDOW_S = 20.0
"""Within so long, seconds, each channel is at rest more often than anywhere else; rest drifts between."""
CONSTANT = 1e-6
"""A channel that varies by less, of its largest value, says nothing."""
PLAYED = 0.1
"""A shape that the calibration never plays above this weight cannot be learnt."""


@dataclass(frozen=True)
class GaugeRegression:
    """Upper shapes as a linear function of the channels: at rest where all of them are."""

    channels: tuple[str, ...]
    shapes: tuple[str, ...]
    scale: Float[np.ndarray, " channels"]
    """Standard deviation of each channel in the calibration."""
    matrix: Float[np.ndarray, "channels shapes"]
    """What a standard deviation of each channel adds."""
    errors: Float[np.ndarray, " shapes"]
    """Distance from the tracked weight where the calibration was held out, root mean square."""
    frozen: Float[np.ndarray, " shapes"]
    """The same of the mean weight: what a number must beat."""
    notes: tuple[str, ...]
    """What was left out, a line each."""

    def weights(self, gauges: GaugeTable, rate: float, frames: int) -> Float[np.ndarray, "frames shapes"]:
        """Weights of the shapes, 0..1; a frame before the first reading or after the last holds the nearest."""
        inputs = _inputs(gauges.only(self.channels), rate, frames) / self.scale
        return np.clip(inputs @ self.matrix, 0.0, 1.0)


def learn_gauges(calibration: Performance, gauges: GaugeTable, others: GaugeTable) -> GaugeRegression:
    """Learn from a take in which the whole face was tracked while `gauges` were read; `others` are to be played.

    Raises:
        BadInput: no common channel that varies, or too little of the calibration with readings.
    """
    channels, notes = _common_channels(gauges, others)
    inputs = _inputs(gauges.only(channels), calibration.rate, len(calibration))
    used = _frames_read(gauges, len(calibration), calibration.rate) & calibration.tracked
    seconds = used.sum() / calibration.rate
    if seconds < SHORTEST_S:
        raise BadInput(
            f"{gauges.name}: the calibration has {seconds:.1f} s of tracked face with readings; {SHORTEST_S:g} s are "
            f"the least ({_told_times(gauges, len(calibration), calibration.rate)})"
        )
    upper = upper_shapes(calibration.rig.names)
    upper &= calibration.weights[used].max(0) > PLAYED
    shapes = tuple(name for name, there in zip(calibration.rig.names, upper, strict=True) if there)
    if not shapes:
        raise BadInput(f"{gauges.name}: brows, lids and cheeks are at rest in all of the calibration; move them in it")
    others_there = np.array(calibration.rig.names)[upper_shapes(calibration.rig.names)]
    at_rest = [name for name in others_there if name not in shapes]
    if at_rest:
        notes.append(f"{gauges.name}: at rest in the calibration, so not learnt: {', '.join(at_rest)}")
    inputs, targets = inputs[used], calibration.weights[used][:, upper]
    scale = inputs.std(0)
    inputs = inputs / scale
    errors = _held_out(inputs, targets, calibration.rate)
    best = errors.argmin(0)
    solved = np.stack([_ridge(inputs, targets, penalty) for penalty in PENALTIES])
    matrix = np.take_along_axis(solved, best[None, None], 0)[0]
    told = np.take_along_axis(errors, best[None], 0)[0]
    return GaugeRegression(channels, shapes, scale, matrix, told, targets.std(0), tuple(notes))


def drive_upper(performance: Performance, regression: GaugeRegression, gauges: GaugeTable) -> Performance:
    """The performance, its upper shapes as the gauges say.

    Raises:
        BadInput: the readings and the take have no time in common.
    """
    check_overlap(gauges, len(performance), performance.rate)
    found = regression.weights(gauges, performance.rate, len(performance))
    weights = performance.weights.copy()
    for name, column in zip(regression.shapes, found.T, strict=True):
        if name in performance.rig.names:
            weights[:, performance.rig.index(name)] = column
    return replace(performance, weights=weights)


def check_overlap(gauges: GaugeTable, frames: int, rate: float) -> int:
    """See that some readings fall into a take; returns how many of its frames have none.

    Raises:
        BadInput: none does.
    """
    read = _frames_read(gauges, frames, rate)
    if not read.any():
        raise BadInput(
            f"{gauges.name}: no reading falls into the take ({_told_times(gauges, frames, rate)}); times count in "
            "seconds from the take's first frame"
        )
    return int((~read).sum())


def _told_times(gauges: GaugeTable, frames: int, rate: float) -> str:
    first, last = gauges.times[[0, -1]]
    return f"readings from {first:.1f} to {last:.1f} s, frames from 0 to {frames / rate:.1f} s"


def _frames_read(gauges: GaugeTable, frames: int, rate: float) -> np.ndarray:
    """Mask of the frames that lie within the readings."""
    times, slack = np.arange(frames) / rate, 1.0 / rate
    return (times > gauges.times[0] - slack) & (times < gauges.times[-1] + slack)


def _common_channels(gauges: GaugeTable, others: GaugeTable) -> tuple[tuple[str, ...], list[str]]:
    """Channels that both have and that vary in both, and a line on those left out."""
    notes = []
    for one, other in ((gauges, others), (others, gauges)):
        missing = [name for name in one.channels if name not in other.channels]
        if missing:
            notes.append(f"{other.name}: lacks {', '.join(missing)} of {one.name}; left out")
    common = [name for name in gauges.channels if name in others.channels]
    for table in (gauges, others):
        still = [name for name in common if not _varies(table.only((name,)).values[:, 0])]
        if still:
            notes.append(f"{table.name}: constant or empty, left out: {', '.join(still)}")
        common = [name for name in common if name not in still]
    if not common:
        said = "; ".join(notes) or "none at all"
        raise BadInput(f"{others.name}: no channel is left that both tables have and that varies ({said})")
    return tuple(common), notes


def _varies(values: np.ndarray) -> bool:
    known = values[np.isfinite(values)]
    return len(known) > 1 and bool(np.ptp(known) > CONSTANT * np.abs(known).max())


def _inputs(gauges: GaugeTable, rate: float, frames: int) -> Float[np.ndarray, "frames channels"]:
    """Each channel's mean over each frame's time, less what it reads at rest."""
    edges = (np.arange(frames + 1) - 0.5) / rate
    out = np.empty((frames, len(gauges.channels)))
    for i, values in enumerate(gauges.values.T):
        known = np.isfinite(values)
        out[:, i] = _means(gauges.times[known], values[known], edges)
    return out - _rest(out, rate)


def _rest(values: Float[np.ndarray, "frames channels"], rate: float) -> Float[np.ndarray, "frames channels"]:
    """What each channel reads at rest, by windows, and on the line between their middles."""
    count = max(1, round(len(values) / rate / WINDOW_S))
    windows = np.array_split(np.arange(len(values)), count)
    middles = [window.mean() for window in windows]
    found = [[_most_often(channel[window]) for window in windows] for channel in values.T]
    return np.stack([np.interp(np.arange(len(values)), middles, levels) for levels in found], axis=1)


def _most_often(values: Float[np.ndarray, " n"]) -> float:
    """The half-sample mode: the densest half, of that the densest half, and so on (Bickel and Fruehwirth 2006)."""
    values = np.sort(values)
    while len(values) > 3:
        half = (len(values) + 1) // 2
        first = int((values[half - 1 :] - values[: len(values) - half + 1]).argmin())
        values = values[first : first + half]
    return float(values.mean())


def _means(times: np.ndarray, values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Means between the edges of the line through the readings, held flat beyond its ends."""
    times = np.r_[min(times[0], edges[0]) - 1, times, max(times[-1], edges[-1]) + 1]
    values = np.r_[values[0], values, values[-1]]
    area = np.r_[0.0, np.cumsum(np.diff(times) * (values[1:] + values[:-1]) / 2)]
    at = np.clip(np.searchsorted(times, edges, "right") - 1, 0, len(times) - 2)
    within = edges - times[at]
    slope = (values[at + 1] - values[at]) / (times[at + 1] - times[at])
    whole = area[at] + within * (values[at] + slope * within / 2)
    return np.diff(whole) / np.diff(edges)


def _ridge(inputs: np.ndarray, targets: np.ndarray, penalty: float) -> Float[np.ndarray, "channels shapes"]:
    """min |X b - y|^2 + penalty |b|^2."""
    return np.linalg.solve(inputs.T @ inputs + penalty * np.eye(inputs.shape[1]), inputs.T @ targets)


def _held_out(inputs: np.ndarray, targets: np.ndarray, rate: float) -> Float[np.ndarray, "penalties shapes"]:
    """Distances on the parts left out, root mean square."""
    fold = (np.arange(len(inputs)) / rate // STRETCH_S % FOLDS).astype(int)
    squares = np.zeros((len(PENALTIES), targets.shape[1]))
    for out in range(FOLDS):
        kept, left = fold != out, fold == out
        for i, penalty in enumerate(PENALTIES):
            found = inputs[left] @ _ridge(inputs[kept], targets[kept], penalty)
            squares[i] += ((np.clip(found, 0, 1) - targets[left]) ** 2).sum(0)
    return np.sqrt(squares / len(inputs))
