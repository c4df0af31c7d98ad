"""Scans of a clip, neutral first, become frames of one topology with labelled dots: what `mien detail fit` reads."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from ...errors import BadInput
from ..disk.light_scan import LightScan
from ..light_rig import RigView
from .common_surface import CommonConfig, CommonSurface, RegisteredSkin, common_surface
from .dot_tracks import DotTrackConfig, TrackedDots, follow_dots, moved_head
from .dots import DotConfig, find_dots


@dataclass(frozen=True)
class TrainingConfig:
    """How scans of clips come into one texture space."""

    dots: DotConfig = DotConfig()
    track: DotTrackConfig = DotTrackConfig()
    common: CommonConfig = field(default_factory=CommonConfig)


@dataclass(frozen=True)
class TrainingFrame:
    """One scan in the common texture space."""

    number: int
    """Of the capture within its clip."""
    dots: TrackedDots
    skin: RegisteredSkin


@dataclass(frozen=True)
class LostFrame:
    """A capture that is left out, and why."""

    number: int
    why: str


def common_neutral(neutral: LightScan, config: TrainingConfig = TrainingConfig()) -> CommonSurface:
    """The texture space, on the neutral and the dots that it shows.

    Raises:
        BadInput: no surface, or hardly a dot on it.
    """
    return common_surface(neutral, find_dots(neutral, config.dots), config.common)


def registered_clip(
    surface: CommonSurface,
    scans: Iterable[LightScan | BadInput],
    view: RigView,
    config: TrainingConfig = TrainingConfig(),
) -> Iterator[TrainingFrame | LostFrame]:
    """A clip's frames, one by one: dots followed from the last ones, the surface laid on them, refined by flow.

    Args:
        scans: in order, laid out in `view`; an error in a scan's place is a capture that could not be decoded.
    """
    dots, step = None, None
    for number, scan in enumerate(scans):
        try:
            if isinstance(scan, BadInput):
                raise scan
            before = moved_head(surface.dots, surface.mesh, scan) if dots is None else dots
            tracked = follow_dots(before, find_dots(scan, config.dots), config.track, step)
        except BadInput as error:
            yield LostFrame(number, str(error))
            continue
        step = None if dots is None else tracked.positions - dots
        dots = tracked.positions
        yield TrainingFrame(number, tracked, surface.register(scan, view, dots))


def shown_positions(dots: TrackedDots) -> np.ndarray:
    """Places of dots, (k, 3), mm; NaN for those that were lost."""
    return np.where(dots.seen[:, None], dots.positions, np.nan)
