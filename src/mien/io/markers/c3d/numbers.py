"""Numbers as the three processors of the C3D format store them.

Layout after the C3D user guide (https://www.c3d.org): Intel and MIPS store IEEE floats, little and big end first; DEC
stores integers as Intel does and floats as VAX F floats.
"""

import numpy as np
from jaxtyping import Float, Int

INTEL, DEC, MIPS = 84, 85, 86
"""The processor byte of the parameter section."""

_VAX_BIAS = 4.0
"""A VAX F float, its 16-bit halves swapped, reads as IEEE four times too large (bias 129 against 127)."""


def words(data: bytes, processor: int) -> Int[np.ndarray, " words"]:
    """Signed 16-bit integers; a last odd byte is left out."""
    order = ">" if processor == MIPS else "<"
    return np.frombuffer(data, f"{order}i2", len(data) // 2).astype(np.int64)


def floats(data: bytes, processor: int) -> Float[np.ndarray, " floats"]:
    """32-bit floats; last odd bytes are left out. What is no number comes as NaN or infinity."""
    count = len(data) // 4
    if processor != DEC:
        order = ">" if processor == MIPS else "<"
        return _widened(np.frombuffer(data, f"{order}f4", count))
    halves = np.frombuffer(data, "<u2", 2 * count).reshape(count, 2)
    swapped = np.ascontiguousarray(halves[:, ::-1])
    return _widened(swapped.view("<f4")[:, 0]) / _VAX_BIAS


def one_float(data: bytes, processor: int) -> float:
    """The first 32-bit float; 0 where there is none or it is not finite."""
    found = floats(data[:4], processor)
    return float(found[0]) if len(found) and np.isfinite(found[0]) else 0.0


def _widened(values: np.ndarray) -> Float[np.ndarray, " floats"]:
    """As float64; a signalling NaN is no reason to warn."""
    with np.errstate(invalid="ignore"):
        return values.astype(np.float64)
