"""How one person makes each expression: generic units bent and scaled, and what they do to one another."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ...rig import Rig
from ...transforms import rotation_from_vector
from .anatomy import Ball, Hinge
from .fields import paired_field, smooth_field, symmetric_field

VECTOR = np.array([-1.0, 1.0, 1.0])
"""A displacement's signs in a mirror."""
CHANNELS = np.concatenate([[1.0], -VECTOR, VECTOR])
"""Of a scalar, a rotation vector and a displacement."""
FREE = ("eyeLook", "tongueOut")
"""Units that every person makes alike: eyes turn, tongues come out."""
JAW = ("jawOpen", "mouthClose")
"""Units that turn about the jaw's hinge."""


@dataclass(frozen=True)
class StyleConfig:
    """How far a performer's expressions are from the generic units. All zeros: the generic units, added up."""

    gain: float = 0.15
    """Standard deviation over space of each unit's size (1 = twice as large here, nothing there)."""
    turn: float = 0.17
    """Standard deviation of the rotation of each unit's motion, radians a component."""
    extra: float = 0.13
    """Further smooth motion where the unit moves, as a share of its size."""
    bow: float = 0.12
    """How far a unit's path bends away from a straight line half way, as a share of its size."""
    saturation: float = 0.22
    """How much of the smaller of two overlapping motions is lost when both are made."""
    mixing: float = 0.15
    """Smooth random motion that appears when two overlapping units are made together, share of the smaller."""
    asymmetry: float = 0.45
    """0: both sides of the face behave alike; 1: nothing in common."""
    wavelength: tuple[float, float] = (60.0, 180.0)
    """Shortest and longest waves of the fields, mm."""
    pairs: int = 160
    """How many pairs of units interact: those that overlap most. 0: none do."""


def styled_units(
    rig: Rig, points: Float[np.ndarray, "n 3"], hinges: tuple[Hinge, Hinge], config: StyleConfig,
    rng: np.random.Generator,
) -> Float[np.ndarray, "shapes n 3"]:
    """The rig's displacements as this person makes them at full weight: scaled, turned and added to, smoothly.

    `mouthClose` takes the fields of `jawOpen`, since it undoes that; blinks are only turned a little, since lids
    must meet; gaze and tongue are left alone. `points` is this person's neutral face, `hinges` the generic jaw's and
    this person's.
    """
    units = np.array(rig.deltas, dtype=np.float64)
    for name in JAW:
        units[rig.index(name)] += _own_jaw(units[rig.index(name)], rig.neutral.vertices, points, hinges)
    fields = _unit_fields(rig, units, points, config, rng)
    for k, name in enumerate(rig.names):
        if name.startswith(FREE):
            continue
        (moved, field), strength = fields[name], _strength(name)
        gain, turn, extra = field[:, :1], field[:, 1:4], field[:, 4:]
        R = rotation_from_vector(np.clip(turn * config.turn * strength, -0.4, 0.4))
        scale = np.clip(1.0 + config.gain * strength * gain, 0.6, 1.4)
        own = units[k, moved]
        size = np.linalg.norm(own, axis=1, keepdims=True)
        units[k, moved] = scale * np.einsum("nij,nj->ni", R, own) + config.extra * strength * size * extra
    return units


def _own_jaw(units: np.ndarray, generic: np.ndarray, own: np.ndarray, hinges: tuple[Hinge, Hinge]) -> np.ndarray:
    """What a jaw unit changes by where the jaw turns about its owner's hinge, by its owner's angle."""
    (first, second), before = jaw_turn(generic, hinges[0]), hinges[0].angle
    whole = np.sin(before) * first + (1 - np.cos(before)) * second
    first_own, second_own = jaw_turn(own, hinges[1])
    whole_own = np.sin(hinges[1].angle) * first_own + (1 - np.cos(hinges[1].angle)) * second_own
    return _share(units, whole)[:, None] * (whole_own - whole)


def jaw_turn(
    points: Float[np.ndarray, "n 3"], hinge: Hinge
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """P and Q of Rodrigues' formula: a point that the jaw carries whole moves by sin(a) P + (1 - cos a) Q."""
    axis = np.array([1.0, 0.0, 0.0])
    first = np.cross(axis, points - hinge.centre)
    return first, np.cross(axis, first)


def _share(units: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """How much of the jaw's whole motion a unit gives each vertex; negative where it takes it back."""
    return np.clip((units * whole).sum(axis=1) / np.maximum((whole**2).sum(axis=1), 1.0), -1.2, 1.2)


def _strength(name: str) -> float:
    """Share of the configured style that a unit takes."""
    if name.startswith("eyeBlink"):
        return 0.3
    if name in JAW:
        return 0.25
    return 0.5 if name.startswith("jaw") else 1.0


def _unit_fields(
    rig: Rig, units: np.ndarray, points: np.ndarray, config: StyleConfig, rng: np.random.Generator
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """By unit name: the vertices that it moves, and there gain, turn and extra (7 channels).

    Partners of a left-right pair nearly mirror one another.
    """
    fields: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    waves, apart = config.wavelength, config.asymmetry
    for name in sorted(rig.names):
        if name in fields:
            continue
        if name.endswith("Left") and name not in ("jawLeft", "mouthLeft"):
            other = name.replace("Left", "Right")
            moved = _moved(units[rig.index(name)] + units[rig.index(other)])
            left, right = paired_field(rng, points[moved], waves, CHANNELS, apart)
            fields[name], fields[other] = (moved, left), (moved, right)
        else:
            both = "jawOpen" if name == "mouthClose" else name
            moved = _moved(units[rig.index(name)] + units[rig.index(both)])
            fields[name] = moved, symmetric_field(rng, points[moved], waves, CHANNELS, apart)
    close = _moved(units[rig.index("mouthClose")])
    everywhere = np.zeros((len(points), len(CHANNELS)))
    everywhere[fields["jawOpen"][0]] = fields["jawOpen"][1]
    fields["mouthClose"] = close, everywhere[close]
    return fields


def _moved(displacements: np.ndarray) -> np.ndarray:
    return np.flatnonzero(np.abs(displacements).max(axis=1) > 1e-4)


def bows(
    rig: Rig, units: Float[np.ndarray, "shapes n 3"], eyes: dict[str, Ball], points: Float[np.ndarray, "n 3"],
    config: StyleConfig, rng: np.random.Generator,
) -> Float[np.ndarray, "shapes n 3"]:
    """b_k in d_k(w) = w D_k + 4 w (1 - w) b_k: how far each unit's path bends half way, mm.

    Blinks bend round the eyeball: the rise of the arc over its chord. The jaw's arc is `jaw_arcs`; others bend at will.
    """
    bend = np.zeros_like(units)
    for k, name in enumerate(rig.names):
        if name.startswith("eyeBlink"):
            bend[k] = _round_the_ball(points, units[k], eyes[name.removeprefix("eyeBlink")])
        elif not name.startswith((*FREE, *JAW)):
            moved = _moved(units[k])
            sideways = smooth_field(rng, config.wavelength, 3).at(points[moved]) / np.sqrt(3)
            bend[k, moved] = config.bow * sideways * np.linalg.norm(units[k, moved], axis=1, keepdims=True)
    return bend


def _round_the_ball(points: np.ndarray, motion: np.ndarray, ball: Ball) -> np.ndarray:
    """From the middle of each chord out to the arc round the ball's centre."""
    a, b = points - ball.centre, points + motion - ball.centre
    middle = (a + b) / 2
    length = np.linalg.norm(middle, axis=1, keepdims=True)
    radius = (np.linalg.norm(a, axis=1, keepdims=True) + np.linalg.norm(b, axis=1, keepdims=True)) / 2
    near = np.exp(-np.maximum(radius - ball.radius - 4.0, 0.0) / 4.0) * (a[:, 2:] > 0)
    return middle / np.maximum(length, 1e-9) * (radius - length) * near


def jaw_arcs(
    units: Float[np.ndarray, "n 3"], points: Float[np.ndarray, "n 3"], hinge: Hinge
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """Fields that turn the straight path of a jaw unit into an arc about the hinge.

    They are the share of `jaw_turn` that the unit gives each vertex, and go with sin(w A) - w sin(A) and
    (1 - cos w A) - w (1 - cos A) for the whole angle A, both zero at w = 0 and 1.
    """
    first, second = jaw_turn(points, hinge)
    share = _share(units, np.sin(hinge.angle) * first + (1 - np.cos(hinge.angle)) * second)
    return share[:, None] * first, share[:, None] * second


@dataclass(frozen=True)
class UnitMotion:
    """From weights to what the fields of bent units go with: w, 4 w (1 - w), jaw arcs, products of pairs."""

    jaw: tuple[int, int]
    """Which weights are `jawOpen` and `mouthClose`."""
    angle: float
    """Turn of the jaw at full opening, radians."""
    pairs: "Interactions"

    def __call__(self, weights: Float[np.ndarray, "frames shapes"]) -> Float[np.ndarray, "frames features"]:
        """Features in the order of the basis."""
        A, jaw = self.angle, weights[:, list(self.jaw)]
        arcs = [np.sin(jaw * A) - jaw * np.sin(A), (1 - np.cos(jaw * A)) - jaw * (1 - np.cos(A))]
        opened = weights.copy()
        opened[:, self.jaw[0]] = np.maximum(jaw[:, 0] - jaw[:, 1], 0.0)
        pairs = opened[:, self.pairs.first] * opened[:, self.pairs.second]
        return np.concatenate([weights, 4 * weights * (1 - weights), *arcs, pairs], axis=1)


@dataclass(frozen=True)
class Interactions:
    """What pairs of units do when made together, beyond adding up: w_k w_l times a field."""

    first: np.ndarray
    """Index k, one a pair."""
    second: np.ndarray
    fields: Float[np.ndarray, "pairs n 3"]
    """Millimetres at w_k = w_l = 1."""


def interactions(
    names: tuple[str, ...], units: Float[np.ndarray, "shapes n 3"], points: Float[np.ndarray, "n 3"],
    config: StyleConfig, rng: np.random.Generator,
) -> Interactions:
    """Fields for the `config.pairs` most overlapping pairs: a loss along the common motion, and a random part."""
    size = np.linalg.norm(units, axis=2)
    pairs = _overlapping(names, size, config.pairs)
    fields = np.zeros((len(pairs), *points.shape))
    for p, (k, l) in enumerate(pairs):
        smaller = size[k] * size[l] / np.maximum(size[k] + size[l], 1e-6)
        here = np.flatnonzero(smaller > 0.02)
        field = smooth_field(rng, config.wavelength, 4).at(points[here])
        both = units[k, here] + units[l, here]
        along = both / np.maximum(np.linalg.norm(both, axis=1, keepdims=True), 1.0)
        loss = 2 * config.saturation * np.clip(1.0 + 0.6 * field[:, :1], 0.0, 2.0)
        fields[p, here] = smaller[here, None] * (config.mixing * field[:, 1:] - loss * along)
    index = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return Interactions(index[:, 0], index[:, 1], fields)


def _overlapping(names: tuple[str, ...], size: Float[np.ndarray, "shapes n"], count: int) -> list[tuple[int, int]]:
    """Pairs of units in falling order of their common motion; never gaze, tongue, blinks, or what undoes the jaw."""
    left_out = (*FREE, "eyeBlink", "mouthClose")
    usable = [k for k, name in enumerate(names) if not name.startswith(left_out)]
    scored = []
    for a, k in enumerate(usable):
        for l in usable[a + 1 :]:
            common = size[k] * size[l] / np.maximum(size[k] + size[l], 1e-6)
            scored.append((float((common**2).sum()), k, l))
    return [(k, l) for _, k, l in sorted(scored, reverse=True)[:count]]
