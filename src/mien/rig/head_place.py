"""Where the head of a rig stands, and a take's head motion brought there.

Face space has the head at its origin, looking along +Z. Avatars stand on their feet; some look along -Z (VRM 0.x) or X,
and some lie on their backs (files with +Z up): turned about the scene's origin or by other axes their heads would swing
through the room, or roll where they should nod.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from ..mesh import vertex_normals
from ..transforms import Transform
from .rig import Rig
from .shape_names import match_names

_EYE_DEPTH = 1.6
"""Face space's origin lies 80 mm behind the eyes, this many times the distance of the lids from side to side."""
_PERSONS_DEPTH_MM = 80.0
"""... of a person."""
_FACE_DEPTH = 0.4
"""... where no lids are found: behind the front of what moves, in heights of it."""
_MOVES = 0.05
"""The face is what some shape moves by more than this share of the largest displacement."""
_DOUBTED = np.array([0.5, 0.5, 1.0])
"""A face looks along X or Y only where its normals say so twice as clearly as along Z."""
_LIDS = ("eyeBlinkLeft", "eyeBlinkRight")
_MOUTH = ("jawOpen", "mouthSmileLeft", "mouthSmileRight")
_UPRIGHT = 2.0
AT_ORIGIN_MM = 150.0
"""A head no farther from the origin than this is in face space, as far as head motion goes."""
_OTHER_SIZE = 5.0
"""A head so many times as large or small as a person's is in another unit: how far it travels is scaled along."""
_ELSEWHERE_RAD = np.radians(45.0)
"""A take that faces this far away from +Z on average is turned to it before an avatar plays it."""


@dataclass(frozen=True)
class HeadPlace:
    """A head in its rig's space."""

    centre: Float[np.ndarray, " 3"]
    """The point that face space has at its origin: between the eyes, 80 mm behind them; millimetres."""
    R_rig_face: Float[np.ndarray, "3 3"]
    """By quarter turns: the identity, or for a head that looks along -Z half a turn about Y."""
    scale: float = 1.0
    """How large the head is against a person's, by its lids."""

    @property
    def in_face_space(self) -> bool:
        """Whether the rig stands as face space has it, so that poses hold for it as they are."""
        near = np.linalg.norm(self.centre) <= AT_ORIGIN_MM * min(self.scale, 1.0)
        return bool(near and np.array_equal(self.R_rig_face, np.eye(3)))


def find_head(rig: Rig) -> HeadPlace:
    """Where a rig's head is, from its own shapes: the lids, else all that moves."""
    vertices = rig.neutral.vertices
    moves = np.linalg.norm(rig.deltas, axis=2).max(axis=0, initial=0.0)
    face = moves > _MOVES * moves.max(initial=0.0)
    if not face.any():
        face = np.ones(len(vertices), dtype=bool)
    R_rig_face = _axes(rig, moves * face)
    forward = R_rig_face[:, 2]
    lids = [_middle(rig, name) for name in _LIDS]
    if lids[0] is not None and lids[1] is not None:
        middle, depth = (lids[0] + lids[1]) / 2, _EYE_DEPTH * float(np.linalg.norm(lids[0] - lids[1]))
        return HeadPlace(middle - depth * forward, R_rig_face, depth / _PERSONS_DEPTH_MM)
    low, high = vertices[face].min(axis=0), vertices[face].max(axis=0)
    height = float(np.abs(R_rig_face[:, 1] @ (high - low)))
    front = (low + high) / 2 + np.abs(forward @ (high - low)) / 2 * forward
    return HeadPlace(front - _FACE_DEPTH * height * forward, R_rig_face)


def _axes(rig: Rig, moves: Float[np.ndarray, " n"]) -> Float[np.ndarray, "3 3"]:
    """R_rig_face by quarter turns: ahead is where what moves looks to. Up is +Y, and +Z for a face along Y, or for one
    along X whose lids lie as clearly above the mouth that way.

    Names of sides and places of shapes say nothing else here: on some rigs they are swapped, on others rough.
    """
    looks = moves @ vertex_normals(rig.neutral.vertices, rig.neutral.faces)
    axis = int(np.argmax(np.abs(looks) * _DOUBTED))
    forward, up = np.zeros(3), np.zeros(3)
    forward[axis] = -1.0 if looks[axis] < 0 else 1.0
    up[2 if axis == 1 or (axis == 0 and _stands_along_z(rig)) else 1] = 1.0
    return np.stack([np.cross(up, forward), up, forward], axis=1)


def _stands_along_z(rig: Rig) -> bool:
    """Whether the lids are farther above the mouth along +Z than `_UPRIGHT` times along Y."""
    lids, mouth = ([_middle(rig, name) for name in names] for names in (_LIDS, _MOUTH))
    known = [[place for place in places if place is not None] for places in (lids, mouth)]
    if not all(known):
        return False
    _, y, z = np.mean(known[0], axis=0) - np.mean(known[1], axis=0)
    return bool(z > _UPRIGHT * abs(y))


def place_motion(T_world_face: Transform, head: HeadPlace) -> tuple[Transform, list[str]]:
    """Head poses of a take as motions of a rig's own space (rest -> posed, mm), and lines on what was left out.

    A rig in face space takes them as they are. Elsewhere the head turns about its own centre: where the take was far
    from its world's origin or faced aside, its mean place and direction are left out.
    """
    if head.in_face_space:
        return T_world_face, []
    notes = []
    R, t = T_world_face.rotation, T_world_face.translation
    x, _, z = R[:, :, 2].mean(axis=0)
    yaw = np.arctan2(x, z)
    if abs(yaw) > _ELSEWHERE_RAD:
        ahead = Rotation.from_euler("Y", -yaw).as_matrix()
        R, t = ahead @ R, t @ ahead.T
        notes.append(f"the take faces {np.degrees(yaw):.0f} degrees aside; turned to look ahead")
    middle = np.median(t, axis=0)
    if np.linalg.norm(middle) > AT_ORIGIN_MM:
        t = t - middle
        notes.append(f"the take's mean place, {np.linalg.norm(middle) / 1000:.1f} m from its origin, is left out")
    if not 1 / _OTHER_SIZE < head.scale < _OTHER_SIZE:
        t = t * head.scale
        notes.append(f"the rig's head is {head.scale:.3g} times a person's size; how far it travels is scaled along")
    turn = head.R_rig_face
    R, t = turn @ R @ turn.T, t @ turn.T
    x, y, z = head.centre / 1000
    notes.append(f"the head turns about its own centre, ({x:.2f}, {y:.2f}, {z:.2f}) m")
    return Transform(R, t + head.centre - R @ head.centre), notes


def _middle(rig: Rig, name: str) -> Float[np.ndarray, " 3"] | None:
    """Mean place of what a shape moves, by how far."""
    match = match_names((name,), rig.names)
    if not match.share.any():
        return None
    moved = np.linalg.norm(np.tensordot(match.share[0], rig.deltas, 1), axis=1)
    return moved @ rig.neutral.vertices / moved.sum() if moved.sum() > 0 else None
