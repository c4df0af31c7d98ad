"""Non-negative least squares for many frames at once, on Gram matrices."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from .boxls import box_least_squares


@dataclass(frozen=True)
class NnlsResult:
    """What `nnls` found, one row a frame."""

    values: Float[np.ndarray, "frames k"]
    converged: Bool[np.ndarray, " frames"]
    iterations: Int[np.ndarray, " frames"]
    """Variables that entered or left the passive set."""


def nnls(
    gram: Float[np.ndarray, "k k"] | Float[np.ndarray, "frames k k"],
    linear: Float[np.ndarray, "frames k"],
    warm: Float[np.ndarray, "frames k"] | None = None,
) -> NnlsResult:
    """Minimise 1/2 w'Gw - b'w with w >= 0, for every frame: min |Aw - x|^2 where G = A'A and b = A'x.

    Exact active set on the Gram matrix (Lawson and Hanson 1974, in the form of Bro and de Jong 1997), warm-started
    from frame to frame; see `box_least_squares`. With dependent columns one of the minima is returned.

    Args:
        gram: A'A, one for all frames or one a frame.
        linear: A'x, one row a frame.
        warm: where to start.

    Raises:
        ValueError: sizes that do not agree, or NaN.
    """
    result = box_least_squares(gram, linear, 0.0, np.inf, warm=warm)
    return NnlsResult(result.values, result.converged, result.iterations)
