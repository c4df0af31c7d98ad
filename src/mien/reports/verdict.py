"""What a result is worth, in words."""

from collections.abc import Sequence

import numpy as np

GRADES = ((0.45, "good"), (0.7, "fair"), (1.0, "poor"))
"""Shares of the motion that are missed -> a word; staged takes of strangers come to 0.25 to 0.8."""

WORSE = "worse than a face that does not move"
"""Where more is missed than there was."""

NAMED = 3
"""Doubtful regions that a verdict names."""


POOREST = 0.99
"""Markers left out are told worse than the whole by all: that the whole is worse than frozen they cannot say."""


def grade(missed: float) -> str:
    """A word for the share of the motion that is missed, 0 = none."""
    return next((word for most, word in GRADES if missed < most), WORSE)


def solve_verdict(residual_mm: float, left_out_share: float) -> str:
    """A marker solve: how near the markers, and how much of the motion is told where no marker sits."""
    near = f"Markers are met to {residual_mm:.2f} mm."
    if not np.isfinite(left_out_share):
        return f"{near} How the face fares between them was not tried."
    kept = max(1 - left_out_share, 0.0)
    word = grade(min(left_out_share, POOREST))
    return f"{word.capitalize()}: {kept:.0%} of what markers do is told by the others alone. {near}"


def truth_verdict(missed: float, missed_strongest: float) -> str:
    """A staged performance against its truth."""
    kept, strongest = (max(1 - share, 0.0) for share in (missed, missed_strongest))
    return (
        f"{grade(missed).capitalize()}: {kept:.0%} of the performer's expression is followed over the take, "
        f"{strongest:.0%} where it is strongest."
    )


def scans_verdict(distance_mm: float, doubtful: Sequence[str], regions: int) -> str:
    """Registered scans: the regions, as a person calls them, that do not correspond, of how many; how near the skin."""
    near = f"Skin lies {distance_mm:.2f} mm from the scans."
    if not doubtful:
        return f"All {regions} regions correspond reliably. {near}"
    named = ", ".join(doubtful[:NAMED]) + (", ..." if len(doubtful) > NAMED else "")
    return f"{regions - len(doubtful)} of {regions} regions correspond reliably; look at {named}. {near}"
