"""What people have on their faces: hair over the forehead, a beard, glasses, a headset."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
import trimesh
from jaxtyping import Float, Int

from ...mesh import Mesh, vertex_normals
from ..people.fields import smooth_field
from ..people.performer import Performer, smoothstep
from ..people.skin import Skin, face_map
from .occluders import join

Kind = Literal["hair", "beard", "glasses", "headset"]
HAIR_COLOUR = np.array([0.16, 0.11, 0.08])
"""sRGB."""
HAIR_LENGTH = {"hair": 9.0, "beard": 6.0}
"""How far hair stands off the skin, mm."""
FRINGE = 46.0
"""Height above the eyes where hair begins, mm; ragged by some 5 mm."""
LENS = (22.0, 16.0)
"""Half the width and height of a lens, mm."""
TEMPLE = ((0.0, 0.0, 0.0), (14.0, 0.0, -12.0), (18.0, 2.0, -95.0))
"""From the hinge back to the ear, mm, x outwards."""
WIRE = np.array([0.06, 0.06, 0.07])
"""Colour of the glasses' wire, sRGB."""
RIM = 1.6
"""Radius of the glasses' wire, mm."""
HEADSET = (178.0, 108.0, 96.0)
"""A display's width, height and depth, mm."""
HEADSET_BELOW = 34.0
"""How far its lower edge lies under the eyes, mm."""


@dataclass(frozen=True)
class Worn:
    """One thing that is worn; follows the skin under it, or the skull."""

    mesh: Mesh
    """At rest, face space, mm, coloured."""
    rows: Int[np.ndarray, " v"] | None
    """The actor's vertices that it grows on; None where it sits on the skull."""
    height: Float[np.ndarray, " v"]
    """Of hair above each, mm."""

    def vertices(self, skin: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> Float[np.ndarray, "v 3"]:
        """Where it is on the actor's vertices `skin`, face space, mm."""
        if self.rows is None:
            return self.mesh.vertices
        return skin[self.rows] + self.height[:, None] * vertex_normals(skin, faces)[self.rows]


def wear(actor: Performer | Skin, kind: Kind, seed: int = 0) -> Worn:
    """Hair, a beard, glasses or a headset for one actor."""
    rng = np.random.default_rng([seed, 22])
    if kind in ("glasses", "headset"):
        rigid = _glasses(actor) if kind == "glasses" else _headset(actor)
        return Worn(rigid, None, np.zeros(len(rigid.vertices)))
    points = actor.neutral.vertices
    height = (_head_hair if kind == "hair" else beard_hair)(actor, points, HAIR_LENGTH[kind], rng)
    grown = (height > 0.3) & actor.skin
    faces = actor.neutral.faces[grown[actor.neutral.faces].all(axis=1)]
    rows, local = np.unique(faces, return_inverse=True)
    out = points[rows] + height[rows, None] * vertex_normals(points, actor.neutral.faces)[rows]
    shade = HAIR_COLOUR * rng.uniform(0.7, 1.6, (len(rows), 1))
    return Worn(Mesh(out, local.reshape(-1, 3), colors=np.clip(shade, 0, 1)), rows, height[rows])


def beard_hair(
    actor: Performer | Skin, points: Float[np.ndarray, "p 3"], length: float, rng: np.random.Generator
) -> Float[np.ndarray, " p"]:
    """Height of a beard above the resting skin at `points`, mm; 0 off it and on the lips."""
    if length <= 0:
        return np.zeros(len(points))
    where = face_map(actor.performer if isinstance(actor, Skin) else actor)
    mouth, wing = where.mouth.mean(axis=0), where.wing.mean(axis=0)
    below = smoothstep((0.55 * mouth[1] + 0.45 * wing[1] - points[:, 1] + 0.5 * np.abs(points[:, 0]) - 6) / 8)
    lips = np.exp(-((points[:, 0] / 27) ** 4) - (((points[:, 1] - mouth[1]) / 11) ** 4))
    above_neck = smoothstep((points[:, 1] - where.chin[1] + 22) / 8) * (points[:, 2] > 25)
    ragged = 0.75 + 0.35 * smooth_field(rng, (2.0, 8.0), waves=48).at(points)[:, 0]
    under_eyes = smoothstep((wing[1] - points[:, 1]) / 6)
    return length * np.clip(ragged, 0, 1.5) * below * under_eyes * above_neck * (1 - lips) ** 2


def _head_hair(
    actor: Performer | Skin, points: Float[np.ndarray, "p 3"], length: float, rng: np.random.Generator
) -> Float[np.ndarray, " p"]:
    """Height of the hair over forehead and temples, mm."""
    eyes = face_map(actor.performer if isinstance(actor, Skin) else actor).eye.mean(axis=0)
    ragged = 5.0 * smooth_field(rng, (6.0, 30.0), waves=32).at(points)[:, 0]
    side = np.abs(np.arctan2(points[:, 0], points[:, 2]))
    line = eyes[1] + FRINGE - 45 * np.clip((side - 0.7) / 0.7, 0, 1)
    return length * smoothstep((points[:, 1] + ragged - line) / 4)


def _glasses(actor: Performer | Skin) -> Mesh:
    """Two rims, a bridge and temples of dark wire; lenses are clear."""
    performer = actor.performer if isinstance(actor, Skin) else actor
    parts, front = [], []
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        ball = performer.eyes[side]
        out = np.array([sign, 1.0, 1.0])
        centre = ball.centre + out * [1.5, -3.0, ball.radius + 15.0]
        turn = np.linspace(0, 2 * np.pi, 33)
        rim = centre + np.stack([LENS[0] * np.cos(turn), LENS[1] * np.sin(turn), -2.5 * np.cos(turn) ** 2], axis=1)
        temple = centre + out * [LENS[0], 4.0, -2.5] + out * np.array(TEMPLE)
        parts += [_wire(rim), _wire(temple)]
        front.append(centre - out * [LENS[0], 0.0, 2.5])
    middle = np.mean(front, axis=0) + np.array([0.0, 3.0, 2.0])
    parts.append(_wire(np.stack([front[0], middle, front[1]])))
    return join(parts)


def _headset(actor: Performer | Skin) -> Mesh:
    """A dark box over eyes, brows and forehead, its back inside the face."""
    performer = actor.performer if isinstance(actor, Skin) else actor
    balls = [performer.eyes[side] for side in ("Left", "Right")]
    eyes = np.mean([ball.centre for ball in balls], axis=0)
    middle = eyes + np.array([0.0, HEADSET[1] / 2 - HEADSET_BELOW, balls[0].radius + HEADSET[2] / 2 - 24.0])
    box = trimesh.creation.box(extents=HEADSET).subdivide().subdivide()
    return Mesh(box.vertices + middle, np.asarray(box.faces), colors=np.tile(WIRE, (len(box.vertices), 1)))


def _wire(line: Float[np.ndarray, "k 3"]) -> Mesh:
    """Dark wire along a line."""
    tubes = [trimesh.creation.cylinder(radius=RIM, segment=np.stack(ends), sections=8) for ends in pairwise(line)]
    return join([Mesh(t.vertices, np.asarray(t.faces), colors=np.tile(WIRE, (len(t.vertices), 1))) for t in tubes])
