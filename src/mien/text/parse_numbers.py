"""Numbers out of large texts, as whole arrays."""

import warnings

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

SPACE = 32
"""The highest byte that counts as blank."""


def parse_floats(text: bytes) -> Float[np.ndarray, " tokens"] | None:
    """Blank-separated numbers; None where some token is none."""
    return _parse(text, np.float64)


def parse_integers(text: bytes) -> Int[np.ndarray, " tokens"] | None:
    """Blank-separated whole numbers; None where some token is none."""
    return _parse(text, np.int64)


def token_starts(text: UInt8[np.ndarray, " bytes"]) -> Bool[np.ndarray, " bytes"]:
    """Where a run of non-blank bytes begins."""
    blank = text <= SPACE
    return ~blank & np.concatenate([[True], blank[:-1]])


def tokens_by_line(text: bytes) -> Int[np.ndarray, " lines"]:
    """How many tokens each line has."""
    raw = np.frombuffer(text, np.uint8)
    so_far = np.cumsum(token_starts(raw)) if len(raw) else np.zeros(1, np.int64)
    at_end = so_far[np.flatnonzero(raw == ord("\n"))]
    return np.diff(np.concatenate([[0], at_end, so_far[-1:]]))


def _parse(text: bytes, kind: type) -> np.ndarray | None:
    expected = int(token_starts(np.frombuffer(text, np.uint8)).sum()) if text else 0
    if expected == 0:
        return np.zeros(0, kind)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            values = np.fromstring(text, dtype=kind, sep=" ")
        except ValueError:
            return None
    return values if len(values) == expected else None
