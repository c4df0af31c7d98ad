"""Live Link Face CSV, the iPhone app's and Unreal's form of a performance: 52 weights, head and eye angles.

The app does not document its angles. Read off a recording of a person who holds still with the eyes on the phone (each
eye's angles follow its eyeLook weights at 35 degrees for 1; head and eyes cancel best with these signs), in radians:
HeadYaw to the subject's left, HeadPitch up, HeadRoll to the left shoulder; eye yaw to the subject's right, eye pitch
down. Head rotation = Ry(yaw) Rx(-pitch) Rz(-roll) in face space, the order in which Unreal applies a rotator.
"""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial.transform import Rotation

from ..errors import BadInput
from ..files import existing, whole
from ..rig import Performance, Rig
from ..transforms import Transform
from .markers.tables.delimited_table import pad, read_text

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

EYE_RANGE = np.radians(35.0)
"""How far an eye turns when its eyeLook weight is 1."""
_RATES = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)


@dataclass(frozen=True)
class LiveLinkTake:
    """What a Live Link Face file holds."""

    names: tuple[str, ...]
    """ARKit names (`jawOpen`)."""
    weights: Float[np.ndarray, "frames shapes"]
    head: Float[np.ndarray, "frames 3"]
    """Yaw, pitch, roll as in the file, radians (see the module)."""
    eyes: Float[np.ndarray, "frames 6"]
    """Yaw, pitch, roll of the left eye, then of the right, radians."""
    rate: float
    """Frames a second."""
    tracked: Bool[np.ndarray, " frames"]
    """False where the app saw no face or left the frame out: such frames hold the last value."""

    def rotations(self) -> Float[np.ndarray, "frames 3 3"]:
        """The head's rotation in face space."""
        return Rotation.from_euler("YXZ", self.head * (1, -1, -1)).as_matrix()

    def to_performance(self, rig: Rig) -> Performance:
        """The take on a rig: shapes met by name, the rig's others at 0, the head turning in place.

        Raises:
            BadInput: the rig has none of the names.
        """
        known = [name for name in rig.names if name in self.names]
        if not known:
            raise BadInput(f"the rig has no ARKit shape, only {', '.join(rig.names[:3])}, ...: give one that has")
        weights = np.zeros((len(self.weights), len(rig.names)))
        for name in known:
            weights[:, rig.index(name)] = self.weights[:, self.names.index(name)]
        rotations = self.rotations()
        return Performance(rig, weights, Transform(rotations, np.zeros((len(rotations), 3))), self.rate, self.tracked)


def read_live_link(path: str | Path, rate: float | None = None) -> LiveLinkTake:
    """Read a Live Link Face CSV.

    `rate` in frames a second; by default from the time codes (60 where the take is too short to tell).

    Raises:
        BadInput: missing, not such a file, no row, a cell that is no number.
    """
    path = existing(path)
    rows = [row for row in csv.reader(read_text(path).splitlines()) if any(cell.strip() for cell in row)]
    header = [cell.strip() for cell in rows[0]] if rows else []
    column = {name.lower(): i for i, name in enumerate(header)}
    shapes = [name for name in SHAPES if name.lower() in column]
    if not shapes or "timecode" not in column:
        raise BadInput(f"{path}: is no Live Link Face CSV, whose header is Timecode,BlendShapeCount,{SHAPES[0]},...")
    body = [pad(row, len(header)) for row in rows[1:]]
    if not body:
        raise BadInput(f"{path}: has no frames; the recording is empty")
    values = _values(path, body, [column[name.lower()] for name in shapes])
    angles = _values(path, body, [column.get(name.lower(), -1) for name in (*HEAD, *EYES)])
    places, rate = _clock([row[column["timecode"]] for row in body], rate)
    seen = np.asarray(np.isfinite(values).all(axis=1))
    if not seen.any():
        raise BadInput(f"{path}: has no frame in which a face was seen")
    table, tracked = _hold(np.concatenate([values, np.nan_to_num(angles)], axis=1), seen, places)
    k = len(shapes)
    names = tuple(name[0].lower() + name[1:] for name in shapes)
    return LiveLinkTake(names, table[:, :k], table[:, k : k + 3], table[:, k + 3 :], rate, tracked)


def write_live_link(path: str | Path, performance: Performance, centre: bool = True) -> None:
    """Write a performance as Live Link Face CSV; shapes that the rig does not have are 0, its others are left out.

    Time codes start at 0 and count whole frames a second, so a rate of 59.94 is read as 60. Untracked frames are
    written as they stand. With `centre` yaw counts from where the face looks on average: a lab's axes know no front.

    Raises:
        BadInput: the rig has no ARKit shape, or the folder does not exist.
    """
    rig = performance.rig
    names = [name[0].lower() + name[1:] for name in SHAPES]
    if not set(names) & set(rig.names):
        raise BadInput(f"{path}: the rig has no ARKit shape (has {', '.join(rig.names[:3])}, ...): nothing to write")
    none = np.zeros(len(performance))
    weights = np.stack([performance.weights[:, rig.index(n)] if n in rig.names else none for n in names], axis=1)
    eyes = eye_angles(dict(zip(names, weights.T, strict=True)))
    table = np.concatenate([weights, head_angles(performance, centre), eyes], axis=1)
    rate = max(1, round(performance.rate))
    with whole(path) as temporary, temporary.open("w") as file:
        file.write(",".join(("Timecode", "BlendShapeCount", *SHAPES, *HEAD, *EYES)) + "\n")
        for i, row in enumerate(table):
            seconds, frame = divmod(i, rate)
            code = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{frame:02d}.000"
            file.write(f"{code},{table.shape[1]}," + ",".join(f"{value:.8f}" for value in row) + "\n")


def head_angles(performance: Performance, centre: bool = True) -> Float[np.ndarray, "frames 3"]:
    """Yaw, pitch, roll of the head in Live Link's sense, radians; `centre` as in `write_live_link`."""
    rotations = performance.T_world_face.rotation
    if centre:
        x, _, z = rotations[:, :, 2].mean(axis=0)
        rotations = Rotation.from_euler("Y", -np.arctan2(x, z)).as_matrix() @ rotations
    return Rotation.from_matrix(rotations).as_euler("YXZ") * (1, -1, -1)


def eye_angles(weights: dict[str, Float[np.ndarray, " frames"]]) -> Float[np.ndarray, "frames 6"]:
    """Angles of both eyes from the eyeLook weights, radians in Live Link's sense; roll is 0."""
    columns = []
    for side, left in (("Left", 1), ("Right", -1)):
        outward = weights["eyeLookOut" + side] - weights["eyeLookIn" + side]
        down = weights["eyeLookDown" + side] - weights["eyeLookUp" + side]
        columns += [-left * outward * EYE_RANGE, down * EYE_RANGE, np.zeros_like(down)]
    return np.stack(columns, axis=1)


def _values(path: Path, rows: list[list[str]], columns: list[int]) -> Float[np.ndarray, "rows columns"]:
    """Cells as numbers, NaN for empty ones; column -1 stands for a column that is not there."""
    try:
        cells = [[float(row[i]) if i >= 0 and row[i].strip() else np.nan for i in columns] for row in rows]
    except ValueError as error:
        raise BadInput(f"{path}: holds a cell that is no number ({error}); export it again") from error
    return np.array(cells)


def _clock(codes: list[str], rate: float | None) -> tuple[Int[np.ndarray, " rows"], float]:
    """Places of the rows and the rate, from time codes HH:MM:SS:FF.fff whose FF counts frames of the second."""
    found = [re.fullmatch(r"\s*(\d+):(\d+):(\d+):(\d+(?:\.\d+)?)\s*", code) for code in codes]
    if not all(found):
        return np.arange(len(codes)), rate or 60.0
    h, m, s, frame = np.array([[float(part) for part in match.groups()] for match in found if match]).T
    second = h * 3600 + m * 60 + s
    counted = int(frame.max()) + 1
    near = [r for r in _RATES if counted <= r <= counted + 2]
    base = 60.0 if second[0] == second[-1] and counted <= 60 else float(near[0] if near else counted)
    steps = np.diff(second * base + frame)
    step = float(np.median(steps)) if len(steps) else 1.0
    each = next((k for k in (0.25, 0.5, 1.0, 2.0, 3.0, 4.0) if abs(step - k) < 0.2 * k), 1.0)
    places = np.round((second - second[0]) * base / each + (frame - frame[0]) / each).astype(np.int64)
    if (np.diff(places) <= 0).any() or places[-1] > 50 * len(places) + 1000:
        places = np.arange(len(codes))
    return places, rate or base / each


def _hold(
    table: Float[np.ndarray, "rows columns"], seen: Bool[np.ndarray, " rows"], places: Int[np.ndarray, " rows"]
) -> tuple[Float[np.ndarray, "frames columns"], Bool[np.ndarray, " frames"]]:
    """Rows at their places; frames without a seen row hold the last one (the first one ahead of it)."""
    at = places[seen]
    tracked = np.zeros(places[-1] + 1, dtype=bool)
    tracked[at] = True
    last = np.maximum(np.searchsorted(at, np.arange(len(tracked)), side="right") - 1, 0)
    return table[seen][last], tracked
