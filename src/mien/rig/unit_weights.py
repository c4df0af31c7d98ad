"""Weights between 0 and 1, which is all that glTF viewers and Blender play (they clamp the rest).

A shape X that is played below 0 or above 1 gets companions behind the rig's own shapes:

    X_neg   the other way: -s X, for weights below 0
    X_over  s X, for what a weight has above 1

with s = the largest such weight, or 1. A corrective means nothing of its own at weight 1, so it needs no `_over`: it is
made larger itself. Played with clamping, the split rig shows what was solved; `joined` undoes the split.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from .performance import Performance
from .rig import Rig

CORRECTIVE = "corrective"
"""What the names of corrective shapes begin with."""


def corrective_names(count: int) -> tuple[str, ...]:
    """What a rig's correctives are called: corrective_01 onwards."""
    return tuple(f"{CORRECTIVE}_{i + 1:02d}" for i in range(count))
NEGATIVE, OVER = "_neg", "_over"
"""What the names of companions end with."""
_SLACK = 1e-6
"""A weight outside 0..1 by no more than this is rounding."""
_PARALLEL = 1e-3
"""A companion differs from its shape's multiple by less than this share (float32, and displacements cut to none)."""


def with_unit_weights(performance: Performance) -> Performance:
    """The same performance with every weight in 0..1 (float32 rounding aside); itself where they all are.

    The companions' names are the shapes' and `_neg` or `_over`.
    """
    weights, rig = performance.weights, performance.rig
    low, high = weights.min(axis=0, initial=0.0), weights.max(axis=0, initial=1.0)
    if (low >= -_SLACK).all() and (high <= 1 + _SLACK).all():
        inside = np.clip(weights, 0.0, 1.0)
        return performance if np.array_equal(inside, weights) else replace(performance, weights=inside)
    scale = np.where([name.startswith(CORRECTIVE) for name in rig.names], high, 1.0)
    scaled = weights / scale
    deltas, names, columns = [rig.deltas * scale[:, None, None]], list(rig.names), [np.clip(scaled, 0.0, 1.0)]
    for k, name in enumerate(rig.names):
        for part, sign, suffix in ((-scaled[:, k], -1.0, NEGATIVE), (scaled[:, k] - 1.0, 1.0, OVER)):
            largest = part.max()
            if largest > _SLACK:
                size = max(1.0, float(largest))
                columns.append(np.clip(part, 0.0, None)[:, None] / size)
                deltas.append(sign * size * scale[k] * rig.deltas[k : k + 1])
                names.append(_new(name + suffix, names))
    split = Rig(rig.neutral, np.concatenate(deltas), tuple(names), rig.texture)
    return replace(performance, rig=split, weights=np.concatenate(columns, axis=1))


def joined(rig: Rig, weights: Float[np.ndarray, "frames shapes"]) -> tuple[Rig, Float[np.ndarray, "frames joined"]]:
    """The rig without companions, and the signed weights that show the same: the inverse of `with_unit_weights`.

    A shape counts as a companion where its name says so and it is a multiple of the shape that it is named after.
    """
    share = np.eye(len(rig.names))
    keep = np.ones(len(rig.names), dtype=bool)
    for k, name in enumerate(rig.names):
        base = _base(name)
        if base in rig.names:
            of = rig.index(base)
            factor = _multiple(rig.deltas[k], rig.deltas[of])
            if factor is not None:
                share[k, of], keep[k] = factor, False
    if keep.all():
        return rig, weights
    names = tuple(name for name, kept in zip(rig.names, keep, strict=True) if kept)
    return Rig(rig.neutral, rig.deltas[keep], names, rig.texture), weights @ share[:, keep]


def _base(name: str) -> str:
    for suffix in (NEGATIVE, OVER):
        if name.endswith(suffix):
            return name.removesuffix(suffix)
    return ""


def _multiple(delta: np.ndarray, of: np.ndarray) -> float | None:
    """The factor between two displacements, None where they are no multiples."""
    size = float((of * of).sum())
    factor = float((delta * of).sum()) / size if size > 0 else 0.0
    off = np.linalg.norm(delta - factor * of)
    return factor if factor != 0 and off <= _PARALLEL * np.linalg.norm(delta) else None


def _new(name: str, names: list[str]) -> str:
    while name in names:
        name += "_"
    return name
