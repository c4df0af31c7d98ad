"""Labels of a marker file: subjects, trajectories that nobody named, names that come twice."""

import re
from collections import Counter
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ...clip import visible
from ...errors import BadInput

FEWEST_MARKERS = 6
"""A face needs as many to be told from its mirror image and its neighbours."""
CONTINUOUS_SHARE = 0.5
"""Share of the frames through which an unlabelled trajectory must be seen to count as a marker: shorter ones are the
pieces of one, or ghosts."""

MAIN_SHARE = 0.75
"""Of markers that stand together: from here on the others are a body's that happen to be near."""

_UNLABELLED = re.compile(
    r"(\*\d*|_*unlabell?ed.*|unlbl.*|uname\W*\d*|unnamed.*|unidentified.*|unknown.*|undefined.*|)", re.IGNORECASE
)
_NUMBER_AT_END = re.compile(r"(\d+)\W*$")
_LISTED = 5
"""Labels named in one message."""


def is_unlabelled(label: str) -> bool:
    """What capture programs call trajectories that nobody named: "", "*12", "Unlabeled 3", "uname*4"."""
    return _UNLABELLED.fullmatch(_last_part(label)) is not None


def without_subject(labels: list[str]) -> list[str]:
    """`subject:NAME` -> `NAME`, unless that makes two labels the same (two people in one take keep their prefixes)."""
    short = [_last_part(label) or label for label in labels]
    return short if len(set(short)) == len(set(labels)) else labels


def main_subject(labels: list[str]) -> list[int]:
    """The labels of the subject (`Face:NAME`) that has at least `MAIN_SHARE` of them; all where none has."""
    subjects = [label.rpartition(":")[0] for label in labels]
    if not subjects:
        return []
    subject, times = Counter(subjects).most_common(1)[0]
    main = times >= max(FEWEST_MARKERS, MAIN_SHARE * len(labels))
    return [i for i, other in enumerate(subjects) if other == subject or not main]


def matching(path: Path, labels: list[str], pattern: str) -> list[int]:
    """The labels that match one of the comma-separated patterns (`Actor:*`, `face*`), with or without their subject.

    Raises:
        BadInput: none does.
    """
    wanted = [part.strip().lower() for part in pattern.split(",") if part.strip()]
    names = [{label.lower(), _last_part(label).lower()} for label in labels]
    found = [i for i, both in enumerate(names) if any(fnmatchcase(n, p) for n in both for p in wanted)]
    if not found:
        raise BadInput(f"{path}: no marker matches {pattern!r}; there are {listed(labels)}")
    return found


def choose_labelled(
    path: Path, positions: Float[np.ndarray, "frames markers 3"], labels: list[str]
) -> tuple[list[int], list[str], list[str]]:
    """(which to keep, their names, lines): the labelled ones; where those are too few, unlabelled ones that last.

    Raises:
        BadInput: too few labelled ones, and the unlabelled are in pieces.
    """
    named = [i for i, label in enumerate(labels) if not is_unlabelled(label)]
    rest = [i for i, label in enumerate(labels) if is_unlabelled(label)]
    if len(named) >= FEWEST_MARKERS or not rest:
        lines = [f"{path}: {len(rest)} of {len(labels)} points are not labelled and were left out"] if rest else []
        return named, [labels[i] for i in named], lines
    seen = visible(positions).mean(axis=0) if len(positions) else np.zeros(len(labels))
    lasting = [i for i in rest if seen[i] >= CONTINUOUS_SHARE]
    if seen.any() and len(named) + len(lasting) < FEWEST_MARKERS:
        raise BadInput(
            f"{path}: {len(named)} labelled markers, and of {len(rest)} unlabelled trajectories {len(lasting)} last "
            f"through half of the take; a face needs {FEWEST_MARKERS}: label or join them in the capture program"
        )
    keep = sorted(named + lasting)
    names = [numbered_name(labels[i], i) if is_unlabelled(labels[i]) else labels[i] for i in keep]
    left_out = f", {len(rest) - len(lasting)} in pieces were left out" if len(rest) > len(lasting) else ""
    line = f"{path}: {len(lasting)} unlabelled trajectories are used, named by number ({listed(names)}){left_out}"
    return keep, names, [line]


def numbered_name(label: str, place: int) -> str:
    """`*12` -> U12; without a number of its own, its place in the file, from 1."""
    number = _NUMBER_AT_END.search(label)
    return f"U{number[1] if number else place + 1}"


def number_repeated(path: Path, labels: list[str]) -> tuple[list[str], list[str]]:
    """(labels all different, lines): those that come more than once get _1, _2, ... in the file's order."""
    count = Counter(labels)
    taken = set(labels)
    out, lines = list(labels), []
    for label, times in count.items():
        if times == 1:
            continue
        places = [i for i, other in enumerate(labels) if other == label]
        fresh = _fresh_names(label, times, taken)
        taken |= set(fresh)
        for i, name in zip(places, fresh, strict=True):
            out[i] = name
        lines.append(
            f"{path}: {times} markers are called {label}; numbered {fresh[0]} to {fresh[-1]} in the file's order"
        )
    return out, lines


def listed(labels: list[str]) -> str:
    """A few of them, for a message."""
    more = f" and {len(labels) - _LISTED} more" if len(labels) > _LISTED else ""
    return ", ".join(labels[:_LISTED]) + more


def _fresh_names(label: str, times: int, taken: set[str]) -> list[str]:
    names: list[str] = []
    number = 0
    while len(names) < times:
        number += 1
        if f"{label}_{number}" not in taken:
            names.append(f"{label}_{number}")
    return names


def _last_part(label: str) -> str:
    return label.rsplit(":", 1)[-1].strip()
