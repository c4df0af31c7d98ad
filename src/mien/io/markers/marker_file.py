"""What a marker file holds before its unit is settled, and the checks that make a `Markers` of it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ...clip import Markers, visible
from ...errors import BadInput
from ...one_line import count
from ...units import FACE_SPAN_MM, check_span, cloud_span, face_cluster, parse_unit, settle_unit
from .marker_labels import (
    FEWEST_MARKERS,
    choose_labelled,
    listed,
    main_subject,
    matching,
    number_repeated,
    without_subject,
)

DEFAULT_RATE = 30.0
"""Frames a second of a file that does not say: what most cameras do."""
_GAP_VALUES = (0.0, *(10.0**digits - 1 for digits in range(3, 9)))
"""What programs write into all three coordinates where a marker was not seen: 0, or 999, -9999, 9999999, ..."""
FARTHEST = 1e9
"""Coordinates beyond (in the file's unit; a thousand kilometres of millimetres) are damage, and gaps."""


@dataclass(frozen=True)
class RawTake:
    """A marker file as it stands."""

    positions: Float[np.ndarray, "frames markers 3"]
    """In the file's unit and the lab's axes (+Y up where `up_source` is "file"); NaN for gaps."""
    labels: tuple[str, ...]
    """As in the file: with subjects, "" or "*12" for unlabelled ones, some perhaps twice."""
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


def finish(
    path: Path, raw: RawTake, unit: str | None, rate: float | None, only: str | None = None, whole: bool = False
) -> MarkerFile:
    """Choose the markers, settle their names, unit and rate, and turn a raw take into millimetres.

    Where the take is larger than a face and some markers of it stand together as one, these alone are kept, unless the
    `whole` take is asked for.

    Raises:
        BadInput: no points, fewer than six markers, nothing seen, a rate or unit that cannot be, no match for `only`.
    """
    chosen = choose_markers(path, replace(raw, positions=gaps_to_nan(raw.positions)), only)
    never = check_markers(path, chosen.positions, chosen.labels)
    mm, source, unit_lines = _settled_unit(path, chosen, unit)
    if not whole:
        chosen = _face_alone(path, chosen, mm)
    rate, rate_lines = _settled_rate(path, chosen, rate)
    never_lines = [f"{path}: never seen: {', '.join(never)}"] if never else []
    return MarkerFile(
        markers=Markers(chosen.positions * mm, tuple(without_subject(list(chosen.labels))), rate, chosen.notes),
        unit_mm=mm,
        unit_source=source,
        up_source=raw.up_source,
        warnings=(*chosen.warnings, *never_lines, *unit_lines, *rate_lines),
    )


def choose_markers(path: Path, raw: RawTake, only: str | None) -> RawTake:
    """The markers that match `only`, of these the labelled ones (see `choose_labelled`), under names all different.

    Raises:
        BadInput: none matches; too few.
    """
    labels = list(raw.labels)
    wanted = list(range(len(labels))) if only is None else matching(path, labels, only)
    among = [labels[i] for i in wanted]
    kept, names, chosen_lines = choose_labelled(path, raw.positions[:, wanted], among)
    names, numbered_lines = number_repeated(path, names)
    return replace(
        raw,
        positions=raw.positions[:, [wanted[i] for i in kept]],
        labels=tuple(names),
        warnings=(*raw.warnings, *chosen_lines, *numbered_lines),
    )


def gaps_to_nan(positions: Float[np.ndarray, "frames markers 3"]) -> Float[np.ndarray, "frames markers 3"]:
    """All three coordinates NaN wherever one is not finite, none is near, or all are exactly zero or the same row of
    nines, as many programs write a gap."""
    with np.errstate(invalid="ignore"):
        near = (np.abs(positions) < FARTHEST).all(axis=2)
    alike = (positions == positions[:, :, :1]).all(axis=2)
    gap = ~near | (alike & np.isin(np.abs(positions[:, :, 0]), _GAP_VALUES))
    return np.where(gap[:, :, None], np.nan, positions)


def check_markers(path: Path, positions: Float[np.ndarray, "frames markers 3"], labels: tuple[str, ...]) -> list[str]:
    """Refuse what no face can be solved from; give the labels that are never seen.

    Raises:
        BadInput: see `finish`.
    """
    frames, markers = positions.shape[:2]
    if markers == 0 or frames == 0:
        raise BadInput(f"{path}: has no marker points ({frames} frames, {markers} markers); export labelled markers")
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


def _face_alone(path: Path, raw: RawTake, mm: float) -> RawTake:
    """Without a body, a prop, a second actor beside the face; a warning says so."""
    if cloud_span(raw.positions) * mm <= FACE_SPAN_MM[1]:
        return raw
    face = face_cluster(raw.positions, mm)
    face = face[main_subject([raw.labels[i] for i in face])]
    if not 0 < len(face) < len(raw.labels):
        return raw
    others = [label for i, label in enumerate(raw.labels) if i not in set(face.tolist())]
    line = (
        f"{path}: {len(face)} markers stand together as a face's do and are read, {count(len(others), 'others')} "
        f"left out ({listed(others)}); solve and convert choose by name with --markers PATTERN"
    )
    labels = tuple(raw.labels[i] for i in face)
    return replace(raw, positions=raw.positions[:, face], labels=labels, warnings=(*raw.warnings, line))


def _settled_unit(path: Path, raw: RawTake, unit: str | None) -> tuple[float, str, list[str]]:
    """(mm per unit, where from, lines)."""
    if unit is not None:
        mm = parse_unit(unit)
        check_span(path, raw.positions, mm, f"--units {unit}")
        return mm, "argument", []
    if raw.mm is not None:
        check_span(path, raw.positions, raw.mm, "as the file says")
        return raw.mm, "file", []
    mm, source, note = settle_unit(path, raw.positions)
    return mm, source, [note]


def _settled_rate(path: Path, raw: RawTake, rate: float | None) -> tuple[float, list[str]]:
    lines = []
    if rate is None:
        rate = raw.rate
    if rate is None:
        rate = DEFAULT_RATE
        lines.append(f"{path}: no frame rate in the file; {rate:g} frames/s assumed")
    if not 0 < rate < np.inf:
        raise BadInput(f"{path}: a rate of {rate:g} frames/s cannot be; name the right one")
    return float(rate), lines
