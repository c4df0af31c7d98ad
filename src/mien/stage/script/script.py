"""Performances as weight curves: what the actor is asked to do, timed as people move."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from ...errors import BadInput
from ...faces.arkit import ARKIT_NAMES
from .poses import EMOTIONS, GROUPS, UNITS_IN_TURN, VISEMES

OPPOSED = (
    ("eyeLookUp", "eyeLookDown"), ("eyeLookIn", "eyeLookOut"), ("mouthSmile", "mouthFrown"), ("jawLeft", "jawRight"),
    ("mouthLeft", "mouthRight"), ("eyeWide", "eyeSquint"), ("eyeWide", "eyeBlink"), ("browDown", "browOuterUp"),
    ("mouthPucker", "mouthStretch"), ("mouthFunnel", "mouthPress"), ("jawOpen", "mouthPress"),
)  # fmt: skip
"""Pairs that no muscle makes together: they are scaled down until they add up to at most 1."""


@dataclass(frozen=True)
class Script:
    """A performance before anybody has performed it."""

    weights: Float[np.ndarray, "frames 52"]
    """ARKit weights in 0..1, in the order of `ARKIT_NAMES`."""
    rate: float
    """Frames a second."""
    cues: tuple[tuple[str, int, int], ...] = ()
    """(what, first frame, frame after the last), in order of time."""


def scripted(rate: float = 120.0, seconds: float = 40.0, seed: int = 0) -> Script:
    """A capture session in small: calm, units in turn, a spoken sentence, six emotions, lopsided ones; blinks all over.

    Args:
        seconds: the sections share it: a tenth calm, a third units, a quarter speech, the rest emotions.

    Raises:
        BadInput: rate outside 24..1000, or less than 10 seconds.
    """
    weights, rng = _blank(rate, seconds, 10.0), np.random.default_rng([seed, 3])
    t = len(weights)
    marks = [int(share * t) for share in (0.0, 0.08, 0.40, 0.64, 1.0)]
    cues = [("calm", 0, marks[1])]
    cues += _in_turn(weights, [(n, {n: 1.0}) for n in UNITS_IN_TURN], marks[1], marks[2], rate, rng)
    cues += _speech(weights, marks[2], marks[3], rate, rng)
    emotions = list(EMOTIONS.items())
    cues += _in_turn(weights, emotions, marks[3], marks[4], rate, rng)
    return _finish(weights, rate, rng, cues)


def random_performance(rate: float = 120.0, seconds: float = 30.0, seed: int = 0) -> Script:
    """An ordinary take: sparse random activations in natural groups, talk, glances and blinks.

    Raises:
        BadInput: rate outside 24..1000, or less than 2 seconds.
    """
    weights, rng = _blank(rate, seconds, 2.0), np.random.default_rng([seed, 4])
    t, start = len(weights), int(0.5 * rate)
    cues = []
    while start < t - int(0.8 * rate):
        length = int(rate * rng.uniform(1.0, 3.0))
        if rng.random() < 0.4:
            cues += _speech(weights, start, min(start + length, t), rate, rng)
        else:
            pose, name = _random_pose(rng)
            envelope = _arc(t, start / rate, length / rate, rate, rng)
            _add(weights, pose, envelope)
            cues.append((name, start, min(start + length, t)))
        start += int(length * rng.uniform(0.45, 0.95))
    return _finish(weights, rate, rng, cues)


def frozen(weights: Float[np.ndarray, "frames 52"]) -> Float[np.ndarray, "frames 52"]:
    """The same take with one fixed face: the mean weights."""
    return np.broadcast_to(weights.mean(axis=0), weights.shape).copy()


def minimum_jerk(x: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """0 to 1 over x in 0..1 with no speed and no acceleration at either end (Flash and Hogan 1985)."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x**2)


def ramp(
    times: Float[np.ndarray, " n"], onset: float, rise: float, hold: float, fall: float
) -> Float[np.ndarray, " n"]:
    """Onset, apex, offset: rises from time `onset` for `rise` seconds, holds, and falls; seconds all."""
    up = minimum_jerk((times - onset) / rise)
    return up * (1 - minimum_jerk((times - onset - rise - hold) / fall))


def settle_conflicts(weights: Float[np.ndarray, "frames 52"]) -> Float[np.ndarray, "frames 52"]:
    """Clip to 0..1, scale opposed units down to a sum of 1, and keep `mouthClose` at or below `jawOpen`."""
    out, index = np.clip(weights, 0.0, 1.0), ARKIT_NAMES.index
    for a, b in OPPOSED:
        for first, second in _sided(a, b):
            k, l = index(first), index(second)
            both = np.maximum(out[:, k] + out[:, l], 1.0)
            out[:, k] /= both
            out[:, l] /= both
    jaw, close = index("jawOpen"), index("mouthClose")
    out[:, close] = np.minimum(out[:, close], out[:, jaw])
    return out


def _sided(a: str, b: str) -> list[tuple[str, str]]:
    """Every pair of the two units' sides, but left with right."""
    sides = [("", ""), ("Left", "Left"), ("Right", "Right"), ("", "Left"), ("", "Right"), ("Left", ""), ("Right", "")]
    pairs = [(a + x, b + y) for x, y in sides]
    return [(p, q) for p, q in pairs if p in ARKIT_NAMES and q in ARKIT_NAMES and p != q]


def _blank(rate: float, seconds: float, least: float) -> np.ndarray:
    if not 24 <= rate <= 1000:
        raise BadInput(f"rate: expected 24 to 1000 frames a second, got {rate}")
    if seconds < least:
        raise BadInput(f"seconds: expected at least {least:g}, got {seconds:g}")
    return np.zeros((round(rate * seconds), len(ARKIT_NAMES)))


def _finish(weights: np.ndarray, rate: float, rng: np.random.Generator, cues: list) -> Script:
    _glances(weights, rate, rng)
    _blinks(weights, rate, rng)
    _restless(weights, rate, rng)
    return Script(settle_conflicts(weights), rate, tuple(cues))


def _add(weights: np.ndarray, pose: dict[str, float], envelope: np.ndarray) -> None:
    """Lay a pose over the weights: the larger of the two, rounded where they cross."""
    for name, full in pose.items():
        k = ARKIT_NAMES.index(name)
        old, new = weights[:, k], full * envelope
        weights[:, k] = old + new - old * new if name != "jawOpen" else np.maximum(old, new)


def _arc(t: int, onset: float, length: float, rate: float, rng: np.random.Generator) -> np.ndarray:
    """An envelope: quick rise, apex, slower fall; sometimes it overshoots a little or trembles at the top."""
    rise, fall = length * rng.uniform(0.18, 0.32), length * rng.uniform(0.28, 0.42)
    times = np.arange(t) / rate
    hold = max(length - rise - fall, 0.05)
    shape = ramp(times, onset, rise, hold, fall)
    sag = 1 - rng.uniform(0.0, 0.15) * minimum_jerk((times - onset - rise) / max(hold, 0.1))
    return shape * sag


def _in_turn(weights, poses, first: int, last: int, rate: float, rng: np.random.Generator) -> list:
    """Each pose on its own, one after the other, its units setting in a little apart."""
    each, cues = (last - first) / len(poses), []
    for i, (name, pose) in enumerate(poses):
        a, length = first + i * each, each * 0.92 / rate
        size = rng.uniform(0.75, 1.0)
        for unit, full in pose.items():
            late = rng.uniform(0.0, 0.08) * length if len(pose) > 1 else 0.0
            _add(weights, {unit: full * size}, _arc(len(weights), a / rate + late, length - late, rate, rng))
        cues.append((name, int(a), int(a + each)))
    return cues


def _speech(weights, first: int, last: int, rate: float, rng: np.random.Generator) -> list:
    """Phonemes of some 80-160 ms, coarticulated: each viseme rises before its time and outlives it."""
    t, now, names = len(weights), first / rate, list(VISEMES)
    times, curve = np.arange(t) / rate, np.zeros_like(weights)
    while now < last / rate - 0.2:
        length = rng.uniform(0.08, 0.16)
        viseme = VISEMES[names[rng.integers(len(names))]]
        envelope = ramp(times, now - 0.06, 0.06 + length / 2, length / 4, 0.10) * rng.uniform(0.6, 1.0)
        for unit, full in viseme.items():
            k = ARKIT_NAMES.index(unit)
            curve[:, k] = np.maximum(curve[:, k], full * envelope)
        now += length * (3.0 if rng.random() < 0.08 else 1.0)
    _add_curves(weights, smooth(curve, 0.02 * rate))
    stress = _arc(t, first / rate, max((last - first) / rate, 0.5), rate, rng)
    _add(weights, {"browInnerUp": rng.uniform(0, 0.3), "browOuterUpLeft": rng.uniform(0, 0.25)}, stress)
    return [("speech", int(first), int(last))]


def _add_curves(weights: np.ndarray, curves: np.ndarray) -> None:
    np.maximum(weights, curves, out=weights)


def _random_pose(rng: np.random.Generator) -> tuple[dict[str, float], str]:
    """A natural group of units, or an emotion, at a random size and often lopsided."""
    if rng.random() < 0.35:
        name = list(EMOTIONS)[rng.integers(len(EMOTIONS))]
        pose = EMOTIONS[name]
    else:
        name = list(GROUPS)[rng.integers(len(GROUPS))]
        pose = GROUPS[name]
    size, lean = rng.uniform(0.4, 0.95), rng.normal() * 0.25
    return {
        unit: float(np.clip(full * size * rng.uniform(0.75, 1.2) * (1 + lean * _side(unit)), 0, 1))
        for unit, full in pose.items()
    }, name


def _side(name: str) -> int:
    return 1 if name.endswith("Left") else -1 if name.endswith("Right") else 0


def _blinks(weights: np.ndarray, rate: float, rng: np.random.Generator) -> None:
    """A blink every 2 to 6 seconds: 80 ms down, 40 ms shut, 140 ms up; both eyes nearly together."""
    t, now = len(weights), rng.uniform(0.5, 2.0)
    times = np.arange(t) / rate
    while now < t / rate:
        for side in ("Left", "Right"):
            k = ARKIT_NAMES.index(f"eyeBlink{side}")
            late = rng.uniform(0.0, 0.012)
            blink = ramp(times, now + late, 0.08, 0.04, 0.14)
            wide = ARKIT_NAMES.index(f"eyeWide{side}")
            weights[:, wide] *= 1 - blink
            weights[:, k] = np.maximum(weights[:, k], blink)
        now += rng.uniform(2.0, 6.0)


def _glances(weights: np.ndarray, rate: float, rng: np.random.Generator) -> None:
    """The gaze jumps every 0.4 to 2.5 s (50 ms saccades), lids going along up and down."""
    t, now = len(weights), 0.0
    across, up = np.zeros(t), np.zeros(t)
    while now < t / rate:
        step = minimum_jerk((np.arange(t) / rate - now) / 0.05)
        across += (rng.normal() * 0.25 - across[-1]) * step
        up += (rng.normal() * 0.15 - up[-1]) * step
        now += rng.uniform(0.4, 2.5)
    for side, sign in (("Left", 1), ("Right", -1)):
        for name, curve in (
            ("eyeLookOut", sign * across), ("eyeLookIn", -sign * across), ("eyeLookUp", up), ("eyeLookDown", -up)
        ):  # fmt: skip
            k = ARKIT_NAMES.index(f"{name}{side}")
            weights[:, k] = np.maximum(weights[:, k], np.clip(curve, 0, 1))


def _restless(weights: np.ndarray, rate: float, rng: np.random.Generator) -> None:
    """No face is still: slow drifts of a few per cent in brows, lids and mouth."""
    for name in ("browInnerUp", "mouthPressLeft", "mouthPressRight", "eyeSquintLeft", "eyeSquintRight", "jawForward"):
        noise = smooth(rng.normal(size=(len(weights), 1)), 0.4 * rate)[:, 0]
        noise *= 0.02 / max(float(noise.std()), 1e-9)
        weights[:, ARKIT_NAMES.index(name)] += np.maximum(noise, 0.0)


def smooth(curves: Float[np.ndarray, "frames k"], sigma: float) -> Float[np.ndarray, "frames k"]:
    """Gaussian smoothing along time, `sigma` in frames; ends held."""
    return gaussian_filter1d(curves, sigma, axis=0, mode="nearest")
