"""The cells of a Live Link Face CSV, by whatever program: which columns are what, and in which unit they count."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..rig.shape_names import match_names
from ..text.decode_text import decode_text
from .markers.tables.delimited_table import DELIMITERS, EMPTY, commonest_delimiter, pad

SHAPES = (
    "EyeBlinkLeft", "EyeLookDownLeft", "EyeLookInLeft", "EyeLookOutLeft", "EyeLookUpLeft", "EyeSquintLeft",
    "EyeWideLeft", "EyeBlinkRight", "EyeLookDownRight", "EyeLookInRight", "EyeLookOutRight", "EyeLookUpRight",
    "EyeSquintRight", "EyeWideRight", "JawForward", "JawRight", "JawLeft", "JawOpen", "MouthClose", "MouthFunnel",
    "MouthPucker", "MouthRight", "MouthLeft", "MouthSmileLeft", "MouthSmileRight", "MouthFrownLeft",
    "MouthFrownRight", "MouthDimpleLeft", "MouthDimpleRight", "MouthStretchLeft", "MouthStretchRight",
    "MouthRollLower", "MouthRollUpper", "MouthShrugLower", "MouthShrugUpper", "MouthPressLeft", "MouthPressRight",
    "MouthLowerDownLeft", "MouthLowerDownRight", "MouthUpperUpLeft", "MouthUpperUpRight", "BrowDownLeft",
    "BrowDownRight", "BrowInnerUp", "BrowOuterUpLeft", "BrowOuterUpRight", "CheekPuff", "CheekSquintLeft",
    "CheekSquintRight", "NoseSneerLeft", "NoseSneerRight", "TongueOut",
)  # fmt: skip
"""The app's columns, in its order: ARKit's names with a capital."""
HEAD = ("HeadYaw", "HeadPitch", "HeadRoll")
EYES = ("LeftEyeYaw", "LeftEyePitch", "LeftEyeRoll", "RightEyeYaw", "RightEyePitch", "RightEyeRoll")

NAMES = tuple(name[0].lower() + name[1:] for name in SHAPES)
"""ARKit's names in the app's order."""
_TIMECODE = ("timecode", "time", "timestamp", "tc")
_OTHER = ("blendshapecount", "frame", "index", "subject", "subjectname", "framenumber")
"""Columns that are neither times, shapes nor angles."""
_LOOKED_AT = 20
"""Lines among which the header stands."""
_FEWEST = 10
"""Shapes that make a table without time codes a performance."""
_HIGHEST_WEIGHT, _HIGHEST_PERCENT = 2.0, 110.0
"""Weights above the first are percent, above the second nonsense."""
_LOWEST_WEIGHT = -0.1
_COMMON = 0.01
"""A share of all values: when fewer than that are above 2, they are no percent but faults."""
_HEAD_RAD, _EYES_RAD = 1.9, 1.2
"""Heads and eyes do not turn farther from straight ahead: larger angles are degrees."""
_HIGHEST_DEGREES = 200.0
_DEGREES_A_WEIGHT = 5.0
"""Eye angles in radians are 0.6 times their eyeLook weights, in degrees 35: in between."""


def read_table(path: Path) -> tuple[list[str], list[list[str]]]:
    """Header and rows, whatever parts the cells; decimal points."""
    lines = decode_text(path).splitlines()
    titles = next((i for i, line in enumerate(lines[:_LOOKED_AT]) if _is_header(line)), 0)
    first = next((line for line in lines[titles:] if line.strip()), "")
    delimiter = commonest_delimiter(first)
    rows = [row for row in csv.reader(lines[titles:], delimiter=delimiter) if any(cell.strip() for cell in row)]
    header = [cell.strip() for cell in rows[0]] if rows else []
    body = [_mended(row, header, delimiter) for row in rows[1:]]
    return header, body


def _is_header(line: str) -> bool:
    """Many cells, none of which is a number: some programs write a title or a note ahead of it."""
    cells = re.split(f"[{DELIMITERS}]", line)
    return len(cells) >= _FEWEST and not any(cell.strip(' "')[:1].isdigit() for cell in cells)


def _mended(row: list[str], header: list[str], delimiter: str) -> list[str]:
    if delimiter == ";" and len(row) == len(header) + 1 and row[0].count(":") == 2 and ":" not in row[1]:
        row = [f"{row[0]};{row[1]}", *row[2:]]  # a drop-frame time code that the delimiter cut in two
    if delimiter != ",":
        row = [row[0], *(cell.replace(",", ".") for cell in row[1:])]
    return pad(row, len(header))


@dataclass(frozen=True)
class LiveLinkColumns:
    """What the columns of a file are."""

    names: tuple[str, ...]
    """The ARKit shapes that it has."""
    time: int
    """-1: none."""
    shapes: list[int]
    share: Float[np.ndarray, "columns shapes"]
    """The shapes are the columns at `shapes` times this."""
    angles: list[int]
    turn: Float[np.ndarray, "turns 9"]
    notes: tuple[str, ...]


def find_columns(path: Path, header: list[str]) -> LiveLinkColumns:
    """Which columns are the time, shapes and angles, by name; spelling and order are free.

    Raises:
        BadInput: too few shapes for a performance.
    """
    plain = ["".join(c for c in name.lower() if c.isalnum()) for name in header]
    time = next((plain.index(name) for name in _TIMECODE if name in plain), -1)
    left = [i for i, name in enumerate(plain) if i != time and name and name not in _OTHER]
    left = [i for i in left if plain.index(plain[i]) == i]
    angles = match_names([header[i] for i in left], (*HEAD, *EYES))
    turning = [i for i, row in zip(left, angles.share, strict=True) if row.any()]
    left = [i for i in left if i not in turning]
    match = match_names([header[i][:1].lower() + header[i][1:] for i in left], NAMES)
    found = [i for i, row in zip(left, match.share, strict=True) if row.any()]
    has = np.asarray(match.share.any(axis=0))
    if not has.any() or (time < 0 and has.sum() < _FEWEST):
        raise BadInput(f"{path}: is no Live Link Face CSV, whose header is Timecode,BlendShapeCount,{SHAPES[0]},...")
    notes = []
    if match.loose:
        some = ", ".join(f"{source} = {target}" for target, source in match.loose[:4])
        notes.append(f"{len(match.loose)} shape names matched loosely: {some}{', ...' if len(match.loose) > 4 else ''}")
    missing = [name for name, there in zip(NAMES, has, strict=True) if not there]
    if missing:
        notes.append(f"{int(has.sum())} of 52 shapes are there; missing: {', '.join(missing)}")
    share = match.share[match.share.any(axis=1)][:, has]
    turn = angles.share[angles.share.any(axis=1)]
    names = tuple(name for name, there in zip(NAMES, has, strict=True) if there)
    return LiveLinkColumns(names, time, found, share, turning, turn, tuple(notes))


def numbers(path: Path, rows: list[list[str]], columns: list[int]) -> Float[np.ndarray, "rows columns"]:
    """Cells as numbers, NaN for empty ones."""
    try:
        cells = [[np.nan if row[i].strip().lower() in EMPTY else float(row[i]) for i in columns] for row in rows]
    except ValueError as error:
        raise BadInput(f"{path}: holds a cell that is no number ({error}); export it again") from error
    return np.array(cells).reshape(len(rows), len(columns))


def in_unit(path: Path, values: Float[np.ndarray, "rows columns"]) -> tuple[np.ndarray, list[str]]:
    """Weights in 0..1 or so.

    Raises:
        BadInput: neither weights nor percent.
    """
    known = values[np.isfinite(values)]
    low, high = float(known.min(initial=0.0)), float(known.max(initial=0.0))
    above = float((known > _HIGHEST_WEIGHT).mean()) if len(known) else 0.0
    percent = high > _HIGHEST_WEIGHT and above > _COMMON
    bound = _HIGHEST_PERCENT if percent else _HIGHEST_WEIGHT
    if high > bound or low < _LOWEST_WEIGHT * (100 if percent else 1):
        raise BadInput(
            f"{path}: shapes run from {low:g} to {high:g}, which is neither 0..1 nor percent; export it again"
        )
    return (values / 100, [f"weights run to {high:g}; read as percent"]) if percent else (values, [])


def in_radians(
    path: Path, angles: Float[np.ndarray, "rows 9"], names: tuple[str, ...], values: Float[np.ndarray, "rows shapes"]
) -> tuple[np.ndarray, list[str]]:
    """Head and eye angles in radians.

    Raises:
        BadInput: larger than any angle.
    """
    head, eyes = (float(np.abs(part).max(initial=0.0)) for part in (angles[:, :3], angles[:, 3:]))
    if max(head, eyes) > _HIGHEST_DEGREES:
        raise BadInput(f"{path}: an angle is {max(head, eyes):g}, neither radians nor degrees; export it again")
    looks = np.abs(values[:, [name.startswith("eyeLook") for name in names]]).sum()
    turned = np.abs(angles[:, [3, 4, 6, 7]]).sum()
    by_look = looks > 1.0 and eyes > 1e-3 and turned / looks > _DEGREES_A_WEIGHT
    if head > _HEAD_RAD or eyes > _EYES_RAD or by_look:
        return np.radians(angles), [f"head and eye angles run to {max(head, eyes):.3g}; read as degrees"]
    return angles, []
