"""Which depth image belongs to which colour image: by name, by number, by time; by order only where nothing says."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import BadInput
from .timestamps import stamp_unit

_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_STAMP = 1e5
"""A number in a file's name above this counts as a time stamp, not as a frame."""
_NEAR = 0.5
"""Stamps belong together that differ by less than this share of a frame."""


class Pairing(NamedTuple):
    """Images that belong together."""

    color: list[Path]
    depth: list[Path]
    numbers: np.ndarray
    """Frame numbers of the pairs, as far apart as the frames; from 0 on where the names do not tell."""
    notes: tuple[str, ...]
    seconds: np.ndarray | None = None
    """Times from the first on, where the names are time stamps."""


def pair_images(folder: Path, color: Sequence[Path], depth: Sequence[Path]) -> Pairing:
    """Pair the images of two folders.

    Raises:
        BadInput: nothing says what belongs together.
    """
    stems = [[file.stem for file in files] for files in (color, depth)]
    first, second = _numbers(color), _numbers(depth)
    common = sorted(set(stems[0]) & set(stems[1]), key=stems[0].index)
    if common:
        pairs = [(stems[0].index(stem), stems[1].index(stem)) for stem in common]
    elif first is None or second is None:
        pairs = []
    elif min(first.min(), second.min()) > _STAMP:
        pairs = _nearest(first, second)
    else:
        _, here, there = np.intersect1d(first, second, return_indices=True)
        pairs = list(zip(here.tolist(), there.tolist(), strict=True))
    if not pairs and len(color) == len(depth):
        order = (f"{folder}: the names of colour and depth images do not say which belong together; paired by order",)
        return Pairing(list(color), list(depth), np.arange(len(color), dtype=float), order)
    if not pairs:
        raise BadInput(
            f"{folder}: {len(color)} colour and {len(depth)} depth images, and neither names nor numbers say which "
            "belong together; give both of a pair one number"
        )
    at = [i for i, _ in pairs]
    frames = first[at] if first is not None else np.arange(len(at), dtype=float)
    alone = (len(color) - len(pairs), len(depth) - len(pairs))
    notes = (
        f"{folder}: {alone[0]} colour and {alone[1]} depth images have no partner and are left out; "
        f"{len(pairs)} pairs remain",
    )
    chosen = [color[i] for i in at], [depth[j] for _, j in pairs]
    every = first if first is None or second is None else np.union1d(first, second)
    stamped = len(frames) > 1 and frames.min() > _STAMP and bool((np.diff(frames) > 0).all())
    seconds = (frames - frames[0]) * stamp_unit(frames) if stamped else None
    return Pairing(*chosen, _from_zero(frames, every), notes if any(alone) else (), seconds)


def _numbers(files: Sequence[Path]) -> np.ndarray | None:
    """The last number in the names that differs from name to name; None where there is none.

    A number that all names share, as a camera's or a format's, says nothing.
    """
    found = [_NUMBER.findall(file.stem) for file in files]
    if not files or not all(found):
        return None
    for place in range(-1, -1 - min(map(len, found)), -1):
        values = np.array([float(each[place]) for each in found])
        if len(np.unique(values)) == len(values):
            return values
    return None


def _nearest(color: np.ndarray, depth: np.ndarray) -> list[tuple[int, int]]:
    """For every colour stamp the nearest depth stamp, each used once."""
    gap = np.median(np.diff(np.sort(color))) if len(color) > 1 else np.inf
    away = np.abs(color[:, None] - depth[None])
    best = away.argmin(axis=1)
    mutual = away[:, best].argmin(axis=0) == np.arange(len(color)) if len(color) else np.zeros(0, bool)
    near = away[np.arange(len(color)), best] < _NEAR * gap
    return [(int(i), int(best[i])) for i in np.flatnonzero(near & mutual)]


def _from_zero(frames: np.ndarray, every: np.ndarray | None) -> np.ndarray:
    """Numbers that count frames: where the names skip, they are divided by the step between all images' numbers."""
    if every is None or len(frames) < 2 or (np.diff(frames) <= 0).any():
        return np.arange(len(frames), dtype=float)
    return (frames - frames[0]) / np.diff(np.sort(every)).min()
