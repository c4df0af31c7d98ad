"""Does a printed figure know the true error? Ranks over many takes say so, whatever the units."""

import numpy as np
from jaxtyping import Float
from scipy.stats import rankdata

from ..errors import BadInput


def rank_correlation(printed: Float[np.ndarray, " n"], true: Float[np.ndarray, " n"]) -> float:
    """Spearman's rank correlation of a figure and the error it stands for; ties share their rank.

    Pairs with a NaN are left out; 0 where either does not vary.

    Raises:
        BadInput: fewer than three pairs.
    """
    both = np.isfinite(printed) & np.isfinite(true)
    if both.sum() < 3:
        raise BadInput(f"printed: expected at least 3 takes with both figures, got {both.sum()}")
    a, b = (rankdata(x[both]) - (both.sum() + 1) / 2 for x in (printed, true))
    size = np.linalg.norm(a) * np.linalg.norm(b)
    return float(a @ b / size) if size > 0 else 0.0
