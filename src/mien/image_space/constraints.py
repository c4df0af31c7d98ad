"""What a user says corresponds on two scans: the file, and which scans a change touches.

`constraints.json` (Huang et al. 2011, sec. 6.2, "User Interaction"):

    {"pairs": [{"scans": ["smile.ply", "frown.ply"],
                "points": [[[x, y, z], [x, y, z]], ...],
                "curves": [[[[x, y, z], ...], [[x, y, z], ...]], ...]}]}

Each of `points` is a place on the first scan and the same place of the skin on the second; each of `curves` a line on
the first and the same line on the second, from the same end, as corners of which there may be any number from two up.
Coordinates are those of the scans' files, in the files' units: what a viewer shows when one clicks on the scan. A scan
is named by its file's name, with or without what comes after the dot. `points` or `curves` may be missing.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from ..errors import BadInput
from ..files import existing
from ..transforms import Transform

Curve = tuple[Float[np.ndarray, "p 3"], Float[np.ndarray, "q 3"]]


@dataclass(frozen=True)
class NamedConstraint:
    """Points and curves that are the same on two scans, as the file has them."""

    scans: tuple[str, str]
    points: Float[np.ndarray, "2 k 3"]
    """On the first and on the second, in the files' coordinates."""
    curves: tuple[Curve, ...] = ()
    """Pairs of polylines, from the same end."""


@dataclass(frozen=True)
class PairConstraint:
    """Points and curves that are the same on two scans; face space, mm."""

    scans: tuple[int, int]
    points: Float[np.ndarray, "2 k 3"]
    """On the first and on the second."""
    curves: tuple[Curve, ...] = ()
    """Pairs of polylines, from the same end."""


def read_constraints(path: str | Path) -> tuple[NamedConstraint, ...]:
    """Read `constraints.json`; the format is at the top of this module.

    Raises:
        BadInput: no such file, not JSON, or a pair that does not follow the format.
    """
    try:
        pairs = json.loads(existing(path).read_text())["pairs"]
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: not a JSON file ({error})") from None
    except (TypeError, KeyError):
        raise BadInput(f'{path}: expected {{"pairs": [...]}}') from None
    if not isinstance(pairs, list):
        raise BadInput(f'{path}: "pairs" must be a list')
    return tuple(_pair(pair, f"{path}: pair {i + 1}") for i, pair in enumerate(pairs))


def place_constraints(
    constraints: Sequence[NamedConstraint], names: Sequence[str], T_face_scan: Sequence[Transform]
) -> tuple[PairConstraint, ...]:
    """Constraints by the scans' numbers and in face space.

    Args:
        names: of the scans, as their files are called.
        T_face_scan: from each scan's file to face space; its scale takes the file's unit to mm.

    Raises:
        BadInput: a scan that is not among `names`.
    """
    stems = [Path(name).stem for name in names]
    placed = []
    for constraint in constraints:
        for name in constraint.scans:
            if Path(name).stem not in stems:
                raise BadInput(f"constraints: no scan is called {name}; there are {', '.join(stems[:8])}")
        a, b = (stems.index(Path(name).stem) for name in constraint.scans)
        T = T_face_scan[a], T_face_scan[b]
        points = np.stack([T[k].apply(constraint.points[k]) for k in (0, 1)])
        curves = tuple((T[0].apply(p), T[1].apply(q)) for p, q in constraint.curves)
        placed.append(PairConstraint((a, b), points, curves))
    return tuple(placed)


def touched(constraints: Sequence[PairConstraint], neighbours: Int[np.ndarray, "scans regions m"]) -> list[int]:
    """Scans to redo for these constraints: those they name, and those that are aligned with one of them."""
    named = sorted({i for constraint in constraints for i in constraint.scans})
    beside = np.flatnonzero(np.isin(neighbours, named).any(axis=(1, 2)))
    return sorted({*named, *beside.tolist()})


def _pair(entry: object, where: str) -> NamedConstraint:
    if not isinstance(entry, dict) or not {"points", "curves"} & set(entry):
        raise BadInput(f'{where}: expected {{"scans": [A, B], "points": [...], "curves": [...]}}')
    scans = entry.get("scans")
    if not (isinstance(scans, list) and len(scans) == 2 and all(isinstance(s, str) for s in scans)):
        raise BadInput(f'{where}: "scans" must be two names of files, got {scans}')
    if Path(scans[0]).stem == Path(scans[1]).stem:
        raise BadInput(f"{where}: both scans are {scans[0]}; name two different ones")
    listed = {key: entry.get(key) or [] for key in ("points", "curves")}
    if not all(isinstance(values, list) for values in listed.values()):
        raise BadInput(f'{where}: "points" and "curves" must be lists')
    points = [_line(point, 2, f"{where}: point {i + 1}") for i, point in enumerate(listed["points"])]
    curves = []
    for i, curve in enumerate(listed["curves"]):
        if not (isinstance(curve, list) and len(curve) == 2):
            raise BadInput(f"{where}: curve {i + 1} must be two lines, one on each scan")
        one, two = (_line(line, None, f"{where}: curve {i + 1}") for line in curve)
        curves.append((one, two))
    stacked = np.stack(points, axis=1) if points else np.zeros((2, 0, 3))
    return NamedConstraint((scans[0], scans[1]), stacked, tuple(curves))


def _line(values: object, count: int | None, where: str) -> Float[np.ndarray, "k 3"]:
    """Places [x, y, z]: `count` of them, or two or more that are not all one."""
    try:
        line = np.array(values, dtype=float)
    except (TypeError, ValueError):
        line = np.zeros((0, 0))
    if line.ndim != 2 or line.shape[1] != 3 or not np.isfinite(line).all():
        raise BadInput(f"{where}: expected places [x, y, z], got {str(values)[:60]}")
    if count is not None and len(line) != count:
        raise BadInput(f"{where}: expected {count} places, one on each scan, got {len(line)}")
    if count is None and (len(line) < 2 or not np.ptp(line, axis=0).any()):
        raise BadInput(f"{where}: a line needs two different places or more")
    return line
