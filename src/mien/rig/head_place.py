"""Where the head of a rig stands, and a take's head motion brought there.

Face space has the head at its origin, looking along +Z. Avatars stand on their feet, and some look along -Z (VRM 0.x):
turned about the scene's origin their heads would swing through the room.
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
_FACE_DEPTH = 0.4
"""... where no lids are found: behind the front of what moves, in heights of it."""
_MOVES = 0.05
"""The face is what some shape moves by more than this share of the largest displacement."""
AT_ORIGIN_MM = 150.0
"""A head no farther from the origin than this is in face space, as far as head motion goes."""
_ELSEWHERE_RAD = np.radians(45.0)
"""A take that faces this far away from +Z on average is turned to it before an avatar plays it."""


@dataclass(frozen=True)
class HeadPlace:
    """A head in its rig's space."""

    centre: Float[np.ndarray, " 3"]
    """The point that face space has at its origin: between the eyes, 80 mm behind them; millimetres."""
    R_rig_face: Float[np.ndarray, "3 3"]
    """The identity, or half a turn about Y for a head that looks along -Z."""

    @property
    def in_face_space(self) -> bool:
        """Whether the rig stands as face space has it, so that poses hold for it as they are."""
        return bool(np.linalg.norm(self.centre) <= AT_ORIGIN_MM and self.R_rig_face[2, 2] > 0)


def find_head(rig: Rig) -> HeadPlace:
    """Where a rig's head is, from its own shapes: the lids, else all that moves."""
    vertices = rig.neutral.vertices
    moves = np.linalg.norm(rig.deltas, axis=2).max(axis=0, initial=0.0)
    face = moves > _MOVES * moves.max(initial=0.0)
    if not face.any():
        face = np.ones(len(vertices), dtype=bool)
    normals = vertex_normals(vertices, rig.neutral.faces)
    backward = float((normals[:, 2] * moves * face).sum()) < 0
    R_rig_face = np.diag([-1.0, 1.0, -1.0]) if backward else np.eye(3)
    lids = [_middle(rig, name) for name in ("eyeBlinkLeft", "eyeBlinkRight")]
    if lids[0] is not None and lids[1] is not None:
        middle, depth = (lids[0] + lids[1]) / 2, _EYE_DEPTH * float(np.linalg.norm(lids[0] - lids[1]))
    else:
        low, high = vertices[face].min(axis=0), vertices[face].max(axis=0)
        middle, depth = (low + high) / 2, _FACE_DEPTH * float(high[1] - low[1])
        middle[2] = low[2] if backward else high[2]
    return HeadPlace(middle - depth * R_rig_face[:, 2], R_rig_face)


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
