"""Corrections over a captured performance: a layer of keys, and ranges that are not to be believed.

The page has a twin of this file, `web/src/edits.js`; a test in the browser holds them together.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation, Slerp

from ..transforms import Transform
from .performance import Performance

FADE_S = 0.2
"""Before its first key and behind its last, a curve's correction fades within this time."""


@dataclass(frozen=True)
class Key:
    """What is added to a weight at one moment."""

    time: float
    """Seconds from the first frame."""
    add: float
    """Added to the captured weight."""


@dataclass(frozen=True)
class Edits:
    """A layer of corrections."""

    keys: Mapping[str, tuple[Key, ...]]
    """By shape, in order of time."""
    bad: tuple[tuple[float, float], ...] = ()
    """From and to, seconds: there the capture is replaced by what lies at the range's ends."""
    fade_s: float = FADE_S

    def __len__(self) -> int:
        return sum(map(len, self.keys.values())) + len(self.bad)


def correction(keys: tuple[Key, ...], times: Float[np.ndarray, " t"], fade_s: float) -> Float[np.ndarray, " t"]:
    """What keys add at `times` (seconds): smooth steps from key to key, nothing `fade_s` beyond the ends."""
    if not keys:
        return np.zeros(len(times))
    at = np.array([keys[0].time - fade_s, *(key.time for key in keys), keys[-1].time + fade_s])
    add = np.array([0.0, *(key.add for key in keys), 0.0])
    inside = np.clip(times, at[0], at[-1])
    left = np.clip(np.searchsorted(at, inside, side="right") - 1, 0, len(at) - 2)
    share = (inside - at[left]) / np.maximum(at[left + 1] - at[left], 1e-9)
    step = share * share * (3 - 2 * share)
    return add[left] * (1 - step) + add[left + 1] * step


def apply_edits(performance: Performance, edits: Edits) -> tuple[Performance, tuple[str, ...]]:
    """The performance with its corrections, and the shapes of the layer that the rig does not have.

    A weight stays within 0..1, or within what was captured where that lies beyond.
    """
    edited = performance
    for first, last in edits.bad:
        edited = _bridged(edited, first, last)
    weights = edited.weights.copy()
    times = np.arange(len(weights)) / edited.rate
    for name in set(edits.keys) & set(edited.rig.names):
        k = edited.rig.index(name)
        base = edited.weights[:, k]
        added = base + correction(edits.keys[name], times, edits.fade_s)
        weights[:, k] = np.clip(added, np.minimum(base, 0), np.maximum(base, 1))
    unknown = tuple(name for name in edits.keys if name not in edited.rig.names)
    return replace(edited, weights=weights), unknown


def _bridged(performance: Performance, first: float, last: float) -> Performance:
    """Frames between two moments go straight from the one before to the one after; they count as not tracked."""
    count, rate = len(performance), performance.rate
    before = int(np.clip(np.ceil(first * rate - 1e-9) - 1, 0, count - 1))
    after = int(np.clip(np.floor(last * rate + 1e-9) + 1, 0, count - 1))
    frames = np.arange(before + 1, after)
    if len(frames) == 0:
        return performance
    share = ((frames - before) / (after - before))[:, None]
    weights, tracked = performance.weights.copy(), performance.tracked.copy()
    weights[frames] = weights[before] * (1 - share) + weights[after] * share
    tracked[frames] = False
    pose = performance.T_world_face
    rotation, translation = pose.rotation.copy(), pose.translation.copy()
    turns = Slerp([before, after], Rotation.from_matrix(rotation[[before, after]]))
    rotation[frames] = turns(frames).as_matrix()
    translation[frames] = translation[before] * (1 - share) + translation[after] * share
    moved = Transform(rotation, translation, pose.scale)
    return replace(performance, weights=weights, T_world_face=moved, tracked=tracked)
