"""Errors of a face's motion as shares of the frozen baseline, as the strangers' own script names them."""

import numpy as np


def shares(found: np.ndarray, true: np.ndarray) -> str:
    """Errors of motions from the neutral, (t, v, 3) mm: take / strongest tenth, %."""
    off = found - true
    return f"own {_share(off, true)}, mean removed {_share(off - off.mean(axis=0), true)}"


def world_share(placed: np.ndarray, true: np.ndarray) -> str:
    """The same of skin with its head poses as they were found: `placed` in the true head, (t, v, 3) mm."""
    off = placed - true
    return f"world {_share(off - off.mean(axis=0), true)}"


def _share(error: np.ndarray, true: np.ndarray) -> str:
    frozen = np.linalg.norm(true - true.mean(axis=0), axis=2)
    size = np.linalg.norm(error, axis=2)
    take, tenth = (100 * size[rows].mean() / frozen[rows].mean() for rows in (slice(None), strongest(true)))
    return f"{take:.0f} / {tenth:.0f}"


def strongest(true: np.ndarray) -> np.ndarray:
    """The tenth of the frames in which a face is farthest from its neutral."""
    length = np.linalg.norm(true, axis=2).mean(axis=1)
    return np.argsort(-length)[: max(len(true) // 10, 1)]
