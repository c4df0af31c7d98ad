"""Live Link Face CSV, the iPhone app's and Unreal's form of a performance: 52 weights, head and eye angles.

The app does not document its angles. Read off a recording of a person who holds still with the eyes on the phone (each
eye's angles follow its eyeLook weights at 35 degrees for 1; head and eyes cancel best with these signs), in radians:
HeadYaw to the subject's left, HeadPitch up, HeadRoll to the left shoulder; eye yaw to the subject's right, eye pitch
down. Head rotation = Ry(yaw) Rx(-pitch) Rz(-roll) in face space, the order in which Unreal applies a rotator.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial.transform import Rotation

from ..errors import BadInput
from ..files import existing, whole
from ..mesh import Mesh
from ..rig import Performance, Rig
from ..rig.shape_names import NameMatch, match_names
from ..text.time_codes import read_clock
from ..transforms import Transform
from .live_link_table import EYES, HEAD, NAMES, SHAPES, find_columns, in_radians, in_unit, numbers, read_table

EYE_RANGE = np.radians(35.0)
"""How far an eye turns when its eyeLook weight is 1."""


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
    notes: tuple[str, ...] = ()
    """What was guessed, turned or mended, a line each."""

    def rotations(self) -> Float[np.ndarray, "frames 3 3"]:
        """The head's rotation in face space."""
        return rotations_of(self.head)

    def match_to(self, names: Sequence[str], given: Mapping[str, str] | None = None) -> NameMatch:
        """How the take drives shapes of these names; `given` are pairs by hand.

        Raises:
            BadInput: it drives none.
        """
        match = match_names(self.names, names, given)
        if not match.moved:
            raise BadInput(f"the rig has no ARKit shape, only {', '.join(names[:3])}, ...: give one that has, or --map")
        return match

    def alone(self) -> Performance:
        """The take on a rig that has its names and nothing to show, to be retargeted."""
        nothing = Rig(Mesh(np.eye(3), np.array([[0, 1, 2]])), np.zeros((len(self.names), 3, 3)), self.names)
        return self.to_performance(nothing)

    def to_performance(self, rig: Rig, given: Mapping[str, str] | None = None) -> Performance:
        """The take on a rig: shapes met by name (`match_to`), the rig's others at 0, the head turning in place.

        Raises:
            BadInput: the rig has none of the names.
        """
        weights = self.match_to(rig.names, given).weights(self.weights)
        rotations = self.rotations()
        return Performance(rig, weights, Transform(rotations, np.zeros((len(rotations), 3))), self.rate, self.tracked)


LARGEST = 1e6
"""No weight, percent or angle is as large: such cells, and infinite ones, count as empty."""


def read_live_link(path: str | Path, rate: float | None = None) -> LiveLinkTake:
    """Read a Live Link Face CSV, or what other programs write in its place.

    Names in other spellings and orders, `;` or tabs, decimal commas, percent, degrees and other clocks are understood;
    each guess is one of the take's `notes`.

    `rate` in frames a second; by default from the time codes (60 where the take is too short to tell).

    Raises:
        BadInput: missing, not such a file, no row, a cell that is no number, weights or angles that make no sense.
    """
    path = existing(path)
    header, body = read_table(path)
    columns = find_columns(path, header)
    if not body:
        raise BadInput(f"{path}: has no frames; the recording is empty")
    cells = numbers(path, body, [*columns.shapes, *columns.angles])
    cells = np.where(np.abs(cells) < LARGEST, cells, np.nan)
    k = len(columns.shapes)
    columns_seen = cells[:, :k]
    seen = np.asarray(np.isfinite(columns_seen).all(axis=1))
    if not seen.any():
        raise BadInput(f"{path}: has no frame in which a face was seen")
    raw, in_weights = in_unit(path, columns_seen)
    values = raw @ columns.share
    turned = np.nan_to_num(cells[:, k:]) @ columns.turn
    angles, in_angles = in_radians(path, turned, columns.names, np.nan_to_num(values))
    codes = [row[columns.time] for row in body] if columns.time >= 0 else [""] * len(body)
    clock = read_clock(codes, rate)
    table, tracked = _hold(np.concatenate([values, angles], axis=1), seen, clock.frames)
    n = len(columns.names)
    notes = tuple(f"{path.name}: {line}" for line in (*columns.notes, *in_weights, *in_angles, *clock.notes))
    return LiveLinkTake(columns.names, table[:, :n], table[:, n : n + 3], table[:, n + 3 :], clock.rate, tracked, notes)


def write_live_link(path: str | Path, performance: Performance, centre: bool | None = None) -> None:
    """Write a performance as Live Link Face CSV; shapes that the rig does not have are 0, its others are left out.

    Names may be spelled otherwise (`rig.shape_names`); weights are cut to 0..1. Time codes start at 0 and count
    whole frames a second, so a rate of 59.94 is read as 60. Untracked frames are written as they stand. With
    `centre` yaw counts from where the face looks on average: a lab's axes know no front. By default it does, unless the
    head turns in place, as it does in a take that was a Live Link one: there yaw has its front already.

    Raises:
        BadInput: the rig has no ARKit shape, or the folder does not exist.
    """
    table = live_link_rows(performance, centre)
    rate = max(1, round(performance.rate))
    with whole(path) as temporary, temporary.open("w") as file:
        file.write(",".join(("Timecode", "BlendShapeCount", *SHAPES, *HEAD, *EYES)) + "\n")
        for i, row in enumerate(table):
            seconds, frame = divmod(i, rate)
            code = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{frame:02d}.000"
            file.write(f"{code},{table.shape[1]}," + ",".join(f"{value:.8f}" for value in row) + "\n")


def live_link_rows(performance: Performance, centre: bool | None = None) -> Float[np.ndarray, "frames values"]:
    """Weights in 0..1 and angles in radians, in the app's order; see `write_live_link`.

    Raises:
        BadInput: the rig has no ARKit shape.
    """
    names = performance.rig.names
    match = match_names(names, NAMES)
    if not match.moved:
        raise BadInput(f"the rig has no ARKit shape (has {', '.join(names[:3])}, ...): Live Link has nothing to show")
    weights = np.clip(match.weights(performance.weights), 0.0, 1.0)
    eyes = eye_angles(dict(zip(NAMES, weights.T, strict=True)))
    if centre is None:
        centre = bool(performance.T_world_face.translation.any())
    return np.concatenate([weights, head_angles(performance, centre), eyes], axis=1)


def head_angles(performance: Performance, centre: bool = True) -> Float[np.ndarray, "frames 3"]:
    """Yaw, pitch, roll of the head in Live Link's sense, radians; `centre` as in `write_live_link`."""
    rotations = performance.T_world_face.rotation
    if centre:
        x, _, z = rotations[:, :, 2].mean(axis=0)
        rotations = Rotation.from_euler("Y", -np.arctan2(x, z)).as_matrix() @ rotations
    return Rotation.from_matrix(rotations).as_euler("YXZ") * (1, -1, -1)


def rotations_of(angles: Float[np.ndarray, "frames 3"]) -> Float[np.ndarray, "frames 3 3"]:
    """The head's rotation in face space from Live Link's yaw, pitch, roll."""
    return Rotation.from_euler("YXZ", angles * (1, -1, -1)).as_matrix()


def eye_angles(weights: dict[str, Float[np.ndarray, " frames"]]) -> Float[np.ndarray, "frames 6"]:
    """Angles of both eyes from the eyeLook weights, radians in Live Link's sense; roll is 0."""
    columns = []
    for side, left in (("Left", 1), ("Right", -1)):
        outward = weights["eyeLookOut" + side] - weights["eyeLookIn" + side]
        down = weights["eyeLookDown" + side] - weights["eyeLookUp" + side]
        columns += [-left * outward * EYE_RANGE, down * EYE_RANGE, np.zeros_like(down)]
    return np.stack(columns, axis=1)


def _hold(
    table: Float[np.ndarray, "rows columns"], seen: Bool[np.ndarray, " rows"], places: Int[np.ndarray, " rows"]
) -> tuple[Float[np.ndarray, "frames columns"], Bool[np.ndarray, " frames"]]:
    """Rows at their places; frames without a seen row hold the last one (the first one ahead of it)."""
    at = places[seen]
    tracked = np.zeros(places[-1] + 1, dtype=bool)
    tracked[at] = True
    last = np.maximum(np.searchsorted(at, np.arange(len(tracked)), side="right") - 1, 0)
    return table[seen][last], tracked
