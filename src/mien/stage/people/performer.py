"""A person who is not in the identity space and makes every expression in their own way."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int

from ...mesh import Mesh
from .anatomy import Ball, Contact, rigid_motion
from .muscles import MuscleMotion
from .style import UnitMotion

CHUNK = 64
"""Frames worked on at a time."""


@dataclass(frozen=True)
class Performer:
    """The truth about one person: a neutral face and a nonlinear map from 52 weights to a face."""

    neutral: Mesh
    """In face space, in the bundled topology, mm."""
    names: tuple[str, ...]
    """The ARKit names, one a weight."""
    units: Float[np.ndarray, "shapes n 3"]
    """Each unit made alone at full weight, before lids and lips meet, mm."""
    motion: UnitMotion | MuscleMotion
    """Weights (frames, shapes) -> features (frames, features)."""
    basis: Float[np.ndarray, "features n3"]
    """Displacement fields, flattened, one a feature."""
    eyes: dict[str, Ball]
    """"Left" and "Right", in this person's face."""
    lids: dict[str, Contact]
    lips: Contact
    rigid: tuple[np.ndarray, ...]
    """Vertex sets that move as bodies: eyeballs and both rows of teeth."""
    skin: np.ndarray = field(repr=False)
    """Mask (n,) of skin."""

    def vertices(
        self, weights: Float[np.ndarray, "frames shapes"], rows: Int[np.ndarray, " m"] | None = None
    ) -> Float[np.ndarray, "frames m 3"]:
        """The face, or its vertices `rows`, under each frame's weights, mm, face space.

        Mind the memory: frames * vertices * 3 doubles.
        """
        if rows is not None:
            part, local = self._cut(rows)
            return part.vertices(weights)[:, local]
        out = np.empty((len(weights), *self.neutral.vertices.shape))
        for start in range(0, len(weights), CHUNK):
            out[start : start + CHUNK] = self._chunk(weights[start : start + CHUNK])
        return out

    def stream(self, weights: Float[np.ndarray, "frames shapes"]) -> Iterator[Float[np.ndarray, "n 3"]]:
        """The same, a frame at a time."""
        for start in range(0, len(weights), CHUNK):
            yield from self._chunk(weights[start : start + CHUNK])

    def _cut(self, rows: np.ndarray) -> tuple["Performer", np.ndarray]:
        """A performer of the vertices `rows` and all that they hang on, and where `rows` are in it."""
        bodies = tuple(part for part in self.rigid if np.isin(part, rows).any())
        contacts = [*self.lids.values(), self.lips]
        kept = np.unique(np.concatenate([rows, *bodies, *(c.vertices for c in contacts)]))
        new = np.full(len(self.neutral.vertices), -1)
        new[kept] = np.arange(len(kept))
        basis = self.basis.reshape(len(self.basis), -1, 3)[:, kept].reshape(len(self.basis), -1)
        part = replace(
            self,
            neutral=Mesh(self.neutral.vertices[kept], np.zeros((0, 3), np.int64)),
            units=self.units[:, kept],
            basis=np.ascontiguousarray(basis),
            lids={side: replace(c, vertices=new[c.vertices]) for side, c in self.lids.items()},
            lips=replace(self.lips, vertices=new[self.lips.vertices]),
            rigid=tuple(new[body] for body in bodies),
            skin=self.skin[kept],
        )
        return part, new[rows]

    def mesh(self, weights: Float[np.ndarray, " shapes"]) -> Mesh:
        """One frame's face."""
        return self.neutral.with_vertices(self.vertices(weights[None])[0])

    def _chunk(self, weights: np.ndarray) -> np.ndarray:
        rest = self.neutral.vertices
        points = (self.motion(weights) @ self.basis).reshape(len(weights), -1, 3)
        points += rest
        for part in self.rigid:
            points[:, part] = _as_body(rest[part], points[:, part])
        for side, contact in self.lids.items():
            close_lids(points, rest, contact, weights[:, self.names.index(f"eyeBlink{side}")])
            keep_off(points, rest, self.eyes[side], self.skin)
        jaw, close = (weights[:, self.names.index(name)] for name in ("jawOpen", "mouthClose"))
        part_lips(points, rest, self.lips, np.where(jaw > 0.01, close / np.maximum(jaw, 0.01), 0.0))
        return points


def _as_body(rest: np.ndarray, moved: np.ndarray) -> np.ndarray:
    R, t = rigid_motion(np.broadcast_to(rest, moved.shape), moved)
    return rest @ np.swapaxes(R, 1, 2) + t[:, None, :]


def close_lids(
    points: Float[np.ndarray, "frames n 3"],
    neutral: Float[np.ndarray, "n 3"],
    lids: Contact,
    closing: Float[np.ndarray, " frames"],
) -> None:
    """Bring the upper lid onto the lower one, in place, as the blink completes, and never let it go further.

    Past `closing` = 0.6 the partners' distance is drawn to none, reached at 1; below, only overlap is undone.
    """
    own = points[:, lids.vertices]
    drawn = smoothstep((closing - 0.6) / 0.4)[:, None, None]
    upper, lower = lids.points(neutral)
    apart = ((lower + lids.offset - upper) * lids.normal).sum(axis=1, keepdims=True) < 0
    for _ in range(8):
        gap = _rows(lids.lower, own) + lids.offset - _rows(lids.upper, own)
        overlap = apart * np.maximum((gap * lids.normal).sum(axis=2, keepdims=True), 0.0) * lids.normal
        own = own + _rows(lids.follow_upper, drawn * gap + (1 - drawn) * overlap)
    points[:, lids.vertices] = own


def keep_off(
    points: Float[np.ndarray, "frames n 3"], neutral: Float[np.ndarray, "n 3"], ball: Ball, skin: np.ndarray
) -> None:
    """Push skin that was outside the eyeball back out of it, in place: to 0.2 mm, or where the neutral face has it."""
    rest = np.linalg.norm(neutral - ball.centre, axis=1)
    near = np.flatnonzero(skin & (rest > ball.radius) & (rest < ball.radius + 14) & (neutral[:, 2] > ball.centre[2]))
    clearance = ball.radius + np.minimum(rest[near] - ball.radius, 0.2)
    away = points[:, near] - ball.centre
    height = np.linalg.norm(away, axis=2)
    points[:, near] = ball.centre + away * np.maximum(clearance / np.maximum(height, 1e-9), 1.0)[..., None]


def part_lips(
    points: Float[np.ndarray, "frames n 3"],
    neutral: Float[np.ndarray, "n 3"],
    lips: Contact,
    sealed: Float[np.ndarray, " frames"],
) -> None:
    """Push lips apart, in place, where they would pass through one another: softly (0.3 mm give), each by half.

    Where `sealed` comes near 1 (the mouth is closed over an open jaw) small gaps, up to some 5 mm, are closed too.
    """
    upper, lower = lips.points(neutral)
    rest = np.minimum(((upper - lower) * lips.normal).sum(axis=1), 0.0)
    draw = smoothstep((sealed - 0.7) / 0.3)[:, None]
    own = points[:, lips.vertices]
    for _ in range(3):
        apart = _rows(lips.upper, own) - _rows(lips.lower, own)
        gap = (apart * lips.normal).sum(axis=2) - rest
        aside = np.linalg.norm(apart - (gap + rest)[..., None] * lips.normal, axis=2)
        through = np.maximum(-gap, 0.0) * np.exp(-((aside / 5.0) ** 2))
        open_by = draw * np.maximum(gap, 0.0) * np.exp(-((gap / 6.0) ** 4))
        push = (through**2 / (through + 0.3) - open_by)[..., None] * lips.normal / 2
        own = own + _rows(lips.follow_upper, push) - _rows(lips.follow_lower, push)
    points[:, lips.vertices] = own


def smoothstep(x: np.ndarray) -> np.ndarray:
    """0 below 0, 1 above 1, with level ends."""
    t = np.clip(x, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _rows(matrix, points: np.ndarray) -> np.ndarray:
    """matrix @ points for (frames, n, 3) points."""
    t, n, _ = points.shape
    flat = points.transpose(1, 0, 2).reshape(n, t * 3)
    return (matrix @ flat).reshape(matrix.shape[0], t, 3).transpose(1, 0, 2)
