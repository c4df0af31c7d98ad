"""A take as it was recorded, made ready for scans: head motion out, gaps filled, what was hardly seen left out."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from ..clip import Markers
from ..errors import BadInput
from .gaps import GapConfig, fill_gaps
from .stabilise import StabiliseConfig, Stabilised, stabilise


@dataclass(frozen=True)
class PreprocessTakeConfig:
    """How a take is made ready."""

    stabilise: StabiliseConfig = StabiliseConfig()
    gaps: GapConfig = field(default_factory=lambda: GapConfig(low_rank_s=np.inf))
    least_seen: float = 0.5
    """Markers seen in less than this share of the frames that show any are left out, and so are frames that show less
    than this share of the markers."""


@dataclass(frozen=True)
class PreprocessedTake:
    """A take seen from its head."""

    markers: Markers
    """The markers that were seen often enough, as recorded."""
    stabilised: Stabilised
    """The same in the head's frame."""
    positions: Float[np.ndarray, "frames markers 3"]
    """... with gaps filled, mm."""
    analysed: Int[np.ndarray, " analysed"]
    """Frames that show enough."""
    left_out: tuple[str, ...]
    """Markers that were seen too seldom."""


def preprocess_take(markers: Markers, config: PreprocessTakeConfig = PreprocessTakeConfig()) -> PreprocessedTake:
    """Take out the head's motion and fill gaps.

    Raises:
        BadInput: too little of the take was seen.
    """
    alive = markers.seen[markers.seen.any(axis=1)]
    often = alive.sum(axis=0) >= max(config.least_seen * len(alive), 1)
    if not often.any():
        raise BadInput(
            f"no marker is seen in {config.least_seen:.0%} of the frames that show any; export a more complete take"
        )
    kept = markers.only(np.flatnonzero(often))
    stabilised = stabilise(kept, config.stabilise)
    filled = fill_gaps(stabilised.markers.positions, kept.rate, config.gaps)
    enough = (kept.seen.mean(axis=1) >= config.least_seen) & np.isfinite(filled).all(axis=(1, 2))
    analysed = np.flatnonzero(enough)
    if len(analysed) < 2:
        raise BadInput(f"only {len(analysed)} frame(s) show {config.least_seen:.0%} of the markers; 2 are needed")
    missed = tuple(np.array(markers.labels)[~often].tolist())
    return PreprocessedTake(kept, stabilised, filled, analysed, missed)
