"""Errors of a face's motion as shares of the frozen baseline, as the strangers' own script names them."""

import numpy as np


def shares(found: np.ndarray, true: np.ndarray) -> str:
    """Errors of motions from the neutral, (t, v, 3) mm: take / strongest tenth, %."""
    strong = strongest(true)
    frozen = np.linalg.norm(true - true.mean(axis=0), axis=2)
    off = found - true
    cells = []
    for name, error in (("own", off), ("mean removed", off - off.mean(axis=0))):
        size = np.linalg.norm(error, axis=2)
        take, tenth = (100 * size[rows].mean() / frozen[rows].mean() for rows in (slice(None), strong))
        cells.append(f"{name} {take:.0f} / {tenth:.0f}")
    return ", ".join(cells)


def strongest(true: np.ndarray) -> np.ndarray:
    """The tenth of the frames in which a face is farthest from its neutral."""
    length = np.linalg.norm(true, axis=2).mean(axis=1)
    return np.argsort(-length)[: max(len(true) // 10, 1)]
