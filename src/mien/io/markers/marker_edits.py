"""`take.markers.json` beside a take: names that a user gave its markers, and times at which one was not what it said.

    {"names": {"M012": "lip_left"}, "bad": {"M007": [{"from": 2.0, "to": 2.4}]}}

Markers bear the labels under which the take's file is read; times are seconds from its first frame, both ends within.
Every reading of the take heeds the file: `mien view` writes it, and the next solve uses it.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...clip import Markers
from ...errors import BadInput
from ...files import whole

SUFFIX = ".markers.json"


@dataclass(frozen=True)
class MarkerEdits:
    """What a user said of a take's markers, by the labels of its file."""

    names: Mapping[str, str] = field(default_factory=dict)
    """New names."""
    bad: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    """Seconds (from, to) at which a marker counts as unseen."""

    def __len__(self) -> int:
        return len(self.names) + sum(map(len, self.bad.values()))


def marker_edits_beside(take: str | Path) -> Path:
    """take.c3d -> take.markers.json."""
    return Path(take).with_suffix(SUFFIX)


def marker_edits_from(told: Any, source: str | Path) -> MarkerEdits:
    """What JSON holds.

    Raises:
        BadInput: it is none; `source` is named.
    """
    try:
        names = {str(old): str(new).strip() for old, new in told.get("names", {}).items()}
        bad = {
            str(label): tuple((float(span["from"]), float(span["to"])) for span in spans)
            for label, spans in told.get("bad", {}).items()
        }
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{source}: says nothing of markers ({error!r}); mend it or delete it") from error
    nameless = [old for old, new in names.items() if not new]
    if nameless:
        raise BadInput(f"{source}: {nameless[0]}: an empty name")
    return MarkerEdits({old: new for old, new in names.items() if old != new}, {k: v for k, v in bad.items() if v})


def read_marker_edits(take: str | Path) -> MarkerEdits:
    """What lies beside a take; nothing where nothing does.

    Raises:
        BadInput: it is no such file.
    """
    path = marker_edits_beside(take)
    if not path.is_file():
        return MarkerEdits()
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise BadInput(f"{path}: is no JSON ({error}); mend it or delete it") from error
    return marker_edits_from(told, path)


def write_marker_edits(take: str | Path, edits: MarkerEdits) -> None:
    """Write it beside the take, whole or not at all; nothing to say leaves no file."""
    path = marker_edits_beside(take)
    if not len(edits):
        path.unlink(missing_ok=True)
        return
    bad = {label: [{"from": start, "to": end} for start, end in spans] for label, spans in edits.bad.items()}
    with whole(path) as temporary:
        temporary.write_text(json.dumps({"names": dict(edits.names), "bad": bad}, indent=1) + "\n", encoding="utf-8")


def apply_marker_edits(markers: Markers, edits: MarkerEdits, source: str | Path) -> Markers:
    """The take under its new names, unseen where a marker was bad; labels that it does not have are passed over.

    Raises:
        BadInput: two markers would be called the same.
    """
    labels = tuple(edits.names.get(label, label) for label in markers.labels)
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise BadInput(f"{source}: two markers would be called {twice[0]}; give one of them another name")
    positions = markers.positions.copy()
    seconds = np.arange(len(positions)) / markers.rate
    for m, label in enumerate(markers.labels):
        for start, end in edits.bad.get(label, ()):
            positions[(seconds >= start - SAME_S) & (seconds <= end + SAME_S), m] = np.nan
    return replace(markers, labels=labels, positions=positions)


SAME_S = 1e-6
"""Seconds: a frame this near to an end of a range is in it."""
