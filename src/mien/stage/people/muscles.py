"""Expressions made by muscles, driven through one person's habits; nothing of the bundled shapes is used."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ...faces.arkit import ARKIT_NAMES
from ...landmarks.detector import bundled_landmarks
from .anatomy import Ball
from .muscle_fields import (
    SIDES,
    SIGN,
    SkinMap,
    bump,
    cheek_fields,
    jaw_share,
    lid_turns,
    lip_fields,
    pull_fields,
    tongue_field,
    turn,
)
from .muscle_table import DRIVE, MIDDLE_PULLS, PAIRED_DRIVE, PULLS, UPPER
from .style import VECTOR, StyleConfig, interactions

JOINT = np.array([0.0, -4.0, -14.0])
"""From the middle between the landmarks before the ears to the jaw's joint, mm."""
SEAL = 13.0
"""How far below the lower lip's edge skin goes with lips that close over an open jaw, mm (standard deviation)."""


@dataclass(frozen=True)
class MuscleConfig:
    """How people differ in what they do with the same muscles. All zeros: the table as it stands."""

    strength: float = 0.2
    """Standard deviation of the logarithm of each muscle's reach, partly shared by both sides."""
    sites: float = 2.0
    """Standard deviation of every origin and insertion along the skin, mm a coordinate."""
    habit: float = 0.12
    """Largest activation of a neighbour that a unit brings along."""
    curve: float = 0.35
    """How far response to a rising weight may be from straight: -this to twice this."""
    asymmetry: float = 0.5
    """0: both sides alike; 1: nothing in common."""
    jaw_angle: tuple[float, float] = (0.36, 0.46)
    """Turn of the jaw at full opening, radians: least and most."""
    jaw_slide: tuple[float, float] = (3.0, 8.0)
    """How far its joint slides forward by then, mm."""


@dataclass(frozen=True)
class MuscleMotion:
    """From ARKit weights to what the fields go with: a person's habits, responses, joint and gaze."""

    muscles: tuple[str, ...]
    drive: Float[np.ndarray, "shapes muscles"]
    curve: Float[np.ndarray, " muscles"]
    """Response (1 + c) x / (1 + c x): above 0 it levels off, below it hangs back."""
    pairs: tuple[np.ndarray, np.ndarray]
    """Muscles whose contractions together do more than add up."""
    jaw: tuple[float, float]
    """Turn (radians) and slide (mm) at full opening."""
    lids: tuple[float, float]
    """How far each upper lid turns to close, radians."""
    gaze: float = 0.5
    """Turn of an eye at full weight, radians."""

    def __call__(self, weights: Float[np.ndarray, "frames shapes"]) -> Float[np.ndarray, "frames features"]:
        """Features in the order of `muscle_basis`."""
        a = self.activations(weights)
        named = {name: weights[:, k] for k, name in enumerate(ARKIT_NAMES)}
        angles = self._angles(named)
        turned = np.stack([f(angle) for angle in angles for f in (np.sin, lambda x: 1 - np.cos(x))], axis=1)
        opened = np.clip(named["jawOpen"], 0, 1)
        slide = (self.jaw[1] * opened**2)[:, None]
        first, second = self.pairs
        return np.concatenate([a, a * a, a[:, first] * a[:, second], turned, slide], axis=1)

    def activations(self, weights: Float[np.ndarray, "frames shapes"]) -> Float[np.ndarray, "frames muscles"]:
        """How hard each muscle is contracted; 1 is as hard as its own unit alone asks for."""
        x = np.clip(weights @ self.drive, 0.0, 1.6)
        return (1 + self.curve) * x / (1 + self.curve * x)

    def _angles(self, named: dict[str, np.ndarray]) -> list[np.ndarray]:
        """Jaw, sealed lips, then of each eye: upper lid, lower lid, gaze up, gaze to the left; radians."""
        out = [self.jaw[0] * named["jawOpen"], self.jaw[0] * named["mouthClose"]]
        for side, closing in zip(SIDES, self.lids, strict=True):
            up = named[f"eyeLookUp{side}"] - named[f"eyeLookDown{side}"]
            left = SIGN[side] * (named[f"eyeLookOut{side}"] - named[f"eyeLookIn{side}"])
            blink, squint, wide = (named[f"{name}{side}"] for name in ("eyeBlink", "eyeSquint", "eyeWide"))
            follow = -0.45 * self.gaze * up * (1 - blink)
            upper = closing * (0.95 * blink + 0.12 * squint * (1 - blink) - 0.22 * wide * (1 - blink)) + follow
            lower = closing * (0.14 * squint + 0.05 * blink)
            out += [upper, lower, self.gaze * up, self.gaze * left]
        return out


def muscle_fields(
    where: SkinMap, config: MuscleConfig, rng: np.random.Generator
) -> dict[str, tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]]:
    """Of every muscle by name: its field at full contraction and what the square of it adds, mm."""
    fields, mirror = {}, bundled_landmarks().mirror
    still = np.zeros_like(where.mesh.vertices)
    for name, pull in PULLS.items():
        shared, moved = rng.normal(), rng.normal(size=(2, 3))
        for side in SIDES:
            sites = []
            for (mark, offset), shift in zip((pull.origin, pull.insertion), moved, strict=True):
                own = config.sites * _partly(shift, rng, config.asymmetry)
                place = where.landmarks[mark if side == "Left" else mirror[mark]]
                sites.append(place + (np.array(offset) + own) * (-VECTOR * SIGN[side] if side == "Right" else 1.0))
            size = np.exp(config.strength * _partly(shared, rng, config.asymmetry))
            linear, bulge = pull_fields(where, sites[0], sites[1], pull)
            fields[name + side] = size * linear, size * bulge
    for name, pull in MIDDLE_PULLS.items():
        sites = [where.landmarks[mark] + np.array(offset) for mark, offset in (pull.origin, pull.insertion)]
        fields[name] = pull_fields(where, sites[0], sites[1], pull)
    share = jaw_share(where)[:, None]
    others = {**lip_fields(where), **cheek_fields(where), "tongue": tongue_field(where)}
    others |= {"jawForward": share * [0.0, -1.0, 7.0], "jawLeft": share * [8.0, 0.0, 0.5]}
    others["jawRight"] = share * [-8.0, 0.0, 0.5]
    for name, linear in others.items():
        fields[name] = float(np.exp(config.strength * rng.normal())) * linear, still
    return fields


def _partly(shared: float | np.ndarray, rng: np.random.Generator, asymmetry: float) -> float | np.ndarray:
    """One side's share of what both sides have, and its own."""
    return np.sqrt(1 - asymmetry**2) * shared + asymmetry * rng.normal(size=np.shape(shared))


def draw_drive(
    muscles: tuple[str, ...], config: MuscleConfig, rng: np.random.Generator
) -> Float[np.ndarray, "shapes muscles"]:
    """What each ARKit unit contracts in one person: the table, and habits: neighbours and the other side come along."""
    drive = np.zeros((len(ARKIT_NAMES), len(muscles)))
    for k, name in enumerate(ARKIT_NAMES):
        unit, side = _without_side(name)
        asked = PAIRED_DRIVE[unit] if unit in PAIRED_DRIVE else DRIVE.get(name, {})
        for muscle, amount in asked.items():
            one_sided = unit in PAIRED_DRIVE and muscle + side in muscles
            drive[k, muscles.index(muscle + side if one_sided else muscle)] += amount
        if not asked or name.startswith(("jaw", "tongue", "eyeBlink")):
            continue
        upper = np.array([m.startswith(UPPER) for m in muscles])
        main = int(np.argmax(drive[k]))
        near = np.flatnonzero((upper == upper[main]) & ~np.array([m.startswith(("jaw", "tongue")) for m in muscles]))
        for extra in rng.choice(near, 3, replace=False):
            drive[k, extra] += config.habit * rng.random()
    return drive


def _without_side(name: str) -> tuple[str, str]:
    for side in SIDES:
        if name.endswith(side) and name.removesuffix(side) in PAIRED_DRIVE:
            return name.removesuffix(side), side
    return name, ""


def muscle_basis(
    where: SkinMap, eyes: dict[str, Ball], config: MuscleConfig, style: StyleConfig, rng: np.random.Generator
) -> tuple[MuscleMotion, Float[np.ndarray, "features n3"]]:
    """One person's motion and the fields that its features go with."""
    points, fields = where.mesh.vertices, muscle_fields(where, config, rng)
    muscles = tuple(fields)
    linear, squares = (np.stack([f[i] for f in fields.values()]) for i in (0, 1))
    pairs = interactions(muscles, linear, points, style, rng)
    share, x = jaw_share(where), np.array([1.0, 0.0, 0.0])
    joint = where.landmarks[[234, 454]].mean(axis=0) + JOINT
    seal = share * bump(where.along(where.face.contours["lower_lip"][1:-1]), SEAL)
    turns, closing = [turn(points, joint, x, share), turn(points, joint, -x, seal)], []
    for side in SIDES:
        upper, lower, angle = lid_turns(where, eyes[side], side)
        ball = np.isin(np.arange(len(points)), eyes[side].vertices).astype(float)
        up, left = (turn(points, eyes[side].centre, axis, ball) for axis in (-x, np.array([0.0, 1.0, 0.0])))
        turns += [upper, lower, up, left]
        closing.append(angle)
    curve = config.curve * rng.uniform(-1.0, 2.0, len(muscles))
    jaw = float(rng.uniform(*config.jaw_angle)), float(rng.uniform(*config.jaw_slide))
    motion = MuscleMotion(muscles, draw_drive(muscles, config, rng), curve, (pairs.first, pairs.second), jaw,
                          (closing[0], closing[1]))  # fmt: skip
    turned = np.stack([f for t in turns for f in (t.first, t.second)])
    slide = (share * (points[:, 2] > 0))[None, :, None] * [0.0, 0.0, 1.0]
    basis = np.concatenate([linear, squares, pairs.fields, turned, slide])
    return motion, basis.reshape(len(basis), -1)
