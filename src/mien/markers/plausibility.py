"""Is it a face at all, and is it surely laid on the right way round?"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from .left_out import LeftOutError


@dataclass(frozen=True)
class PlausibilityConfig:
    """From where on a take is doubted, and refused. On twelve takes of faces and ten of other things (hands, bodies,
    boxes, balls, legs, random points) nothing is refused wrongly and only one half ball passes, with a warning."""

    refuse: bool = True
    """False solves whatever it is."""
    worst_shape_mm: float = 3.5
    """Markers this far from any person's face, rms, are no face's (faces: 0.5 to 2.4)."""
    doubtful_shape_mm: float = 1.5
    """... and from this on where nothing moves, or where it might as well lie another way round."""
    unexplained: float = 0.8
    """No expression leaves this share of a motion of `worst_shape_mm` and more, where the shape is doubtful besides."""
    still_mm: float = 0.3
    """Markers that move less than this against one another, rms, are a thing that is carried about."""
    still_fewest: int = 12
    """... and fewer than so many that do not move lie on anything."""
    moving_mm: float = 1.5
    """Markers that move this much tell besides whether a face moves them, if they lie on it either way round."""
    least_margin: float = 0.03
    """An alignment no better than one another way round by this share is a coin's toss (faces: 0.2 to 0.85)."""
    sure_margin: float = 0.15
    """... and below this, of any other alignment, it is doubtful."""
    clear_margin: float = 0.22
    """Markers that are no face's by shape or motion may be one's all the same where the alignment is better than any
    other by this share (lively or long faces of people from another face model: 0.26 to 0.37; half a ball 0.07) ..."""
    farthest_shape_mm: float = 4.5
    """... where they stand no farther than this from any person's face (such a face, a tenth longer and narrower: 3.9)
    ..."""
    most_motion_mm: float = 6.0
    """... and where they move, but no more than this (lively faces: 4.1): markers left out then have the last word."""
    hopeless_share: float = 1.0
    """Where markers left out are told no better than to this share of how far they leave the neutral face, a face at
    rest is as good (faces: 0.2 to 0.6)."""
    untold_share: float = 0.45
    """... and this share is enough where they are no face's by shape or motion (such faces: 0.29 to 0.40; legs 0.53,
    places by hand of which half are mixed up 1.04)."""


@dataclass(frozen=True)
class Fit:
    """What the markers are judged by."""

    shape_mm: float
    """rms distance of the calm frame's markers from the best person's face."""
    motion_mm: float
    """rms of the markers' motion in the head's frame."""
    residual_mm: float
    """rms of what the best person's shapes leave of it."""
    margin: float
    """1 - (residual of the alignment / residual of the best other one)."""
    markers: int = 100
    """How many there are."""
    way_round_margin: float = 1.0
    """As `margin`, of the best other one that lays the markers another way round."""


def motion_of(positions: Float[np.ndarray, "frames markers 3"]) -> float:
    """rms distance of markers (head frame) from their own median places, mm."""
    seen = np.isfinite(positions).all(axis=2)
    place = np.nanmedian(positions[:, seen.any(axis=0)], axis=0)
    return float(np.sqrt(np.nanmean(((positions[:, seen.any(axis=0)] - place) ** 2).sum(axis=2))))


def refuse_no_face(fit: Fit, config: PlausibilityConfig = PlausibilityConfig()) -> None:
    """Refuse markers that no face can wear.

    Raises:
        BadInput: with the reason.
    """
    reason = why_no_face(fit, config)
    if config.refuse and reason and not may_be_a_face(fit, config):
        raise BadInput(
            f"this is no face: {reason}; choose the face's markers with --markers PATTERN, or name the unit with "
            "--units (--attach places the markers of a face that is not recognised)"
        )


def why_no_face(fit: Fit, config: PlausibilityConfig) -> str:
    """The reason, or nothing."""
    if fit.shape_mm > config.worst_shape_mm:
        return f"the markers stand {fit.shape_mm:.1f} mm off the nearest face"
    doubtful = fit.shape_mm > config.doubtful_shape_mm
    if fit.motion_mm < config.still_mm and doubtful:
        return f"nothing moves and the markers stand {fit.shape_mm:.1f} mm off the nearest face"
    if fit.motion_mm < config.still_mm and fit.markers < config.still_fewest:
        return f"nothing moves, and {fit.markers} markers that hold still lie on anything"
    unexplained = fit.residual_mm / max(fit.motion_mm, config.still_mm)
    if fit.motion_mm > config.worst_shape_mm and unexplained > (config.unexplained if doubtful else 1.0):
        return f"the markers move by {fit.motion_mm:.0f} mm as no expression does"
    tossed = fit.way_round_margin < config.least_margin
    if tossed and fit.motion_mm > config.moving_mm and unexplained > config.unexplained:
        return (
            f"the markers move by {fit.motion_mm:.1f} mm as no expression does, and lie on it as well the other way "
            "round"
        )
    if tossed and doubtful:
        return f"the markers stand {fit.shape_mm:.1f} mm off the nearest face and lie on it as well the other way round"
    return ""


def may_be_a_face(fit: Fit, config: PlausibilityConfig) -> bool:
    """Whether markers left out are to say if it is a face, where shape or motion say no."""
    moves = config.moving_mm < fit.motion_mm <= config.most_motion_mm
    return moves and fit.margin >= config.clear_margin and fit.shape_mm <= config.farthest_shape_mm


def refuse_untold(
    shape_mm: float,
    left_out: LeftOutError,
    config: PlausibilityConfig = PlausibilityConfig(),
    unproven: bool = False,
) -> None:
    """Refuse a solve that tells markers left out by turns worse than a face at rest.

    Args:
        shape_mm: how far the calm frame's markers stand off the best person's face.
        left_out: what stands still, or was not tried, is not judged.
        unproven: by shape or motion they are no face's.

    Raises:
        BadInput: with the reason.
    """
    off = shape_mm > config.worst_shape_mm
    bound = config.untold_share if off or unproven else config.hopeless_share
    share = left_out.neutral_share
    if not config.refuse or left_out.motion_mm < config.still_mm or not share >= bound:
        return
    better = "no" if share >= 1 else "hardly"
    stand = f" and the markers stand {shape_mm:.0f} mm off the nearest face" if off else ""
    raise BadInput(
        f"markers left out by turns are told {better} better than by a face at rest ({share:.0%} of their motion "
        f"is missed){stand}: are left and right, or labels, mixed up, in --attach or in the take? Look at it with "
        "`mien view`, choose the face's markers with --markers PATTERN, or name the unit with --units"
    )


def doubts(fit: Fit, config: PlausibilityConfig = PlausibilityConfig()) -> tuple[str, ...]:
    """A line for each thing that is not sure."""
    lines = []
    if fit.margin < config.sure_margin:
        lines.append(
            f"another alignment of the markers explains the take nearly as well (margin {fit.margin:.2f}); look at the "
            "dots in the picture, --attach places the markers by hand"
        )
    if fit.shape_mm > config.doubtful_shape_mm:
        lines.append(
            f"the markers stand {fit.shape_mm:.1f} mm off the nearest face, more than a face's usually do; look at the "
            "dots in the picture"
        )
    return tuple(lines)
