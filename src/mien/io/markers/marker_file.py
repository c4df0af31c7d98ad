"""What a marker file holds before its unit is settled, and the checks that make a `Markers` of it."""

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ...clip import Markers, visible
from ...errors import BadInput
from ..units import check_span, cloud_span, parse_unit, settle_unit

FEWEST_MARKERS = 6


@dataclass(frozen=True)
class RawTake:
    """A marker file as it stands."""

    positions: Float[np.ndarray, "frames markers 3"]
    """In the file's unit and the lab's axes (+Y up where `up_source` is "file"); NaN for gaps."""
    labels: tuple[str, ...]
    rate: float | None
    """Frames a second; None where the file does not say."""
    mm: float | None
    """Millimetres in one unit; None where the file does not say."""
    up_source: str = "unknown"
    """"file" where the file named the up axis and positions are turned to +Y up."""
    notes: dict[str, np.ndarray] | None = None
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class MarkerFile:
    """A marker take and what is known about how it was read."""

    markers: Markers
    unit_mm: float
    """Millimetres in one unit of the file."""
    unit_source: str
    """"argument", "file", "assumed" (a standard unit that makes a face) or "guessed" (scaled to a typical face)."""
    up_source: str
    """"file": positions are +Y up, as the file says; "unknown": they stand in the file's own axes."""
    warnings: tuple[str, ...]
    """One line each, for whoever runs the job: what was assumed, guessed or left out."""


def finish(path: Path, raw: RawTake, unit: str | None, rate: float | None, default_rate: float = 30.0) -> MarkerFile:
    """Check a raw take, settle its unit and rate, and turn it into millimetres.

    Raises:
        BadInput: no points, fewer than six markers, duplicate labels, nothing seen, a rate or unit that cannot be.
    """
    positions = gaps_to_nan(raw.positions)
    never = check_markers(path, positions, raw.labels)
    warnings = [*raw.warnings, *([f"{path}: never seen: {', '.join(never)}"] if never else [])]
    if unit is not None:
        mm, source = parse_unit(unit), "argument"
        check_span(path, cloud_span(positions), mm, f"--units {unit}")
    elif raw.mm is not None:
        mm, source = raw.mm, "file"
        check_span(path, cloud_span(positions), mm, "as the file says")
    else:
        mm, source, note = settle_unit(path, positions)
        warnings.append(note)
    if rate is None:
        rate = raw.rate
    if rate is None:
        rate = default_rate
        warnings.append(f"{path}: no frame rate in the file; {rate:g} frames/s assumed")
    if not 0 < rate < np.inf:
        raise BadInput(f"{path}: a rate of {rate:g} frames/s cannot be; name the right one")
    markers = Markers(positions * mm, raw.labels, float(rate), raw.notes)
    return MarkerFile(markers, mm, source, raw.up_source, tuple(warnings))


def gaps_to_nan(positions: Float[np.ndarray, "frames markers 3"]) -> Float[np.ndarray, "frames markers 3"]:
    """All three coordinates NaN wherever one is not finite or all are exactly zero, as many programs write a gap."""
    gap = ~visible(positions) | (positions == 0).all(axis=2)
    return np.where(gap[:, :, None], np.nan, positions)


def check_markers(path: Path, positions: Float[np.ndarray, "frames markers 3"], labels: tuple[str, ...]) -> list[str]:
    """Refuse what no face can be solved from; give the labels that are never seen.

    Raises:
        BadInput: see `finish`.
    """
    frames, markers = positions.shape[:2]
    if markers == 0 or frames == 0:
        raise BadInput(f"{path}: has no marker points ({frames} frames, {markers} markers); export labelled markers")
    twice = [label for label, count in Counter(labels).items() if count > 1]
    if twice:
        raise BadInput(f"{path}: duplicate marker labels: {', '.join(twice[:5])}; give every marker its own name")
    seen = np.asarray(visible(positions).any(axis=0))
    if not seen.any():
        raise BadInput(f"{path}: all {frames} frames are empty (NA or zero), no marker is ever seen; export it again")
    if seen.sum() < FEWEST_MARKERS:
        raise BadInput(
            f"{path}: only {int(seen.sum())} marker(s) are ever seen; a face needs at least {FEWEST_MARKERS}, "
            "spread over brows, nose and mouth"
        )
    if not cloud_span(positions) > 0:
        raise BadInput(f"{path}: no frame shows two markers apart; nothing to solve from")
    return [labels[i] for i in np.flatnonzero(~seen)]


def without_subject(labels: list[str]) -> list[str]:
    """`subject:NAME` -> `NAME`, unless that makes two labels the same (two people in one take keep their prefixes)."""
    short = [label.rsplit(":", 1)[-1].strip() or label for label in labels]
    return short if len(set(short)) == len(set(labels)) else labels


def is_unlabelled(label: str) -> bool:
    """What capture programs call trajectories that nobody named: "", "*12", "Unlabeled 3", "uname*4"."""
    return re.fullmatch(r"(\*\d*|unlabell?ed.*|uname\W*\d*|)", label.rsplit(":", 1)[-1].strip(), re.I) is not None
