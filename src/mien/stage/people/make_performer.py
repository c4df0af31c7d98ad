"""Making performers: random people outside the identity space, each with a style of their own."""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...faces.bundled import BundledFace, load_face
from .anatomy import Ball, Contact, Hinge, eyeball, jaw_hinge, lid_contact, lip_contact
from .fields import symmetric_field
from .holdout_identities import load_holdout_identities
from .muscles import MuscleConfig, MuscleMotion, SkinMap, muscle_basis
from .performer import Performer, keep_off
from .proportions import warp_shape
from .style import VECTOR, StyleConfig, UnitMotion, bows, interactions, jaw_arcs, styled_units

EYE_WINDOW = 22.0
"""Within this of an eye's centre (mm) the random field turns into a plain shift, so that lids still fit the ball."""
LIP_OVERLAP = 0.5
"""Closed lips of a warped face press on one another by this, mm: subdivision opens them by as much."""
TEETH_BACK = 1.5
"""Teeth behind lips that a warp may have thinned, mm."""


@dataclass(frozen=True)
class PerformerConfig:
    """Who the performer is."""

    identity: float = 0.8
    """Standard deviations of the random coefficients in the identity space. 0: the average face."""
    holdout: float = 0.3
    """Largest weight of the identity targets that the space has never seen. 0: none."""
    holdout_count: int = 24
    """How many of those are taken."""
    displacement: float = 1.5
    """Rms of the smooth random displacement over the skin, mm. 0: none."""
    waves: tuple[float, float] = (35.0, 110.0)
    """Shortest and longest waves of that field, mm."""
    warps: float = 0.0
    """Multiplies the anatomical warps of `proportions`. 0: none."""
    kind: Literal["bent", "muscles"] = "bent"
    """How expressions are made: the bundled units bent, or by muscles that know nothing of them."""
    style: StyleConfig = field(default_factory=StyleConfig)
    """How bent units differ from the generic ones; of muscles, how pairs of them interact."""
    muscles: MuscleConfig = field(default_factory=MuscleConfig)
    """How this person uses their muscles; unused where units are bent."""


STRANGER = PerformerConfig(
    identity=0.1, holdout=0.0, displacement=2.2, waves=(22.0, 62.0), warps=0.8, kind="muscles",
    style=StyleConfig(saturation=0.4, mixing=0.35, pairs=60),
)  # fmt: skip
"""A person of whom about half lies outside the identity space, moved by muscles: what accuracy is to be judged on."""


def make_performer(seed: int, config: PerformerConfig | None = None) -> Performer:
    """A person drawn by `seed`: the same seed gives the same person.

    Raises:
        BadInput: a negative seed.
    """
    config = config or PerformerConfig()
    if seed < 0:
        raise BadInput(f"seed: expected a whole number from 0 on, got {seed}")
    face = load_face()
    rng_shape, rng_style = np.random.default_rng([seed, 1]), np.random.default_rng([seed, 2])
    shifted = face.rig.neutral.vertices + random_shape(face, config, rng_shape)
    lips = lip_contact(face, face.on_skin)
    rounds, overlap = (40, LIP_OVERLAP) if config.warps > 0 else (12, 0.0)
    neutral = _settle(face, shifted, lips, rounds, overlap)
    return _assemble(face, neutral, lips, config, rng_style)


def random_shape(
    face: BundledFace, config: PerformerConfig, rng: np.random.Generator
) -> Float[np.ndarray, "n 3"]:
    """Displacement of a random person's neutral face from the average one, mm."""
    coefficients = config.identity * np.clip(rng.normal(size=len(face.identity.modes)), -2, 2)
    shape = face.identity.displacement(coefficients)
    shape = shape + _holdout(config, rng)
    points = face.rig.neutral.vertices
    own = symmetric_field(rng, points, config.waves, VECTOR, asymmetry=0.35)
    own *= config.displacement / np.sqrt((own[face.parts["skin"]] ** 2).sum(axis=1).mean())
    if config.warps > 0:
        own += config.warps * warp_shape(face, 0.25, rng)
    for side in ("Left", "Right"):
        ball = eyeball(face, points, side)
        window = np.exp(-((np.linalg.norm(points - ball.centre, axis=1) / EYE_WINDOW) ** 4))[:, None]
        own = (1 - window) * own + window * own[ball.vertices].mean(axis=0)
    back = [0.0, 0.0, TEETH_BACK if config.warps > 0 else 0.0]
    jaw = own[face.parts["upper_teeth"]].mean(axis=0) - back
    for teeth in ("upper_teeth", "lower_teeth", "tongue"):
        own[face.parts[teeth]] = jaw
    return shape + own


def _holdout(config: PerformerConfig, rng: np.random.Generator) -> Float[np.ndarray, "n 3"]:
    """A random few of the targets that the identity space has never seen; of two ends of one slider, one."""
    names, targets = load_holdout_identities()
    chosen: dict[str, int] = {}
    for i in rng.permutation(len(names)):
        if len(chosen) < config.holdout_count:
            chosen.setdefault(names[i].rstrip("+-"), i)
    picked = np.array(sorted(chosen.values()), dtype=np.int64)
    return np.tensordot(config.holdout * rng.uniform(0.3, 1.0, len(picked)), targets[picked], axes=1)


def _settle(
    face: BundledFace, vertices: np.ndarray, lips: Contact, rounds: int, overlap: float
) -> np.ndarray:
    """Close the lips and keep the lids outside the eyeballs."""
    vertices = vertices.copy()
    for _ in range(rounds):
        upper, lower = lips.points(vertices)
        apart = ((upper - lower) * lips.normal).sum(axis=1) + overlap
        half = apart[:, None] * lips.normal / 2
        vertices[lips.vertices] += lips.follow_lower @ half - lips.follow_upper @ half
    usual = face.rig.neutral.vertices
    for side in ("Left", "Right"):
        ball, generic = eyeball(face, vertices, side), eyeball(face, usual, side)
        keep_off(vertices[None], usual - generic.centre + ball.centre, ball, face.on_skin)
    return vertices


def _assemble(
    face: BundledFace, neutral: np.ndarray, lips: Contact, config: PerformerConfig, rng: np.random.Generator
) -> Performer:
    """The performer on a finished neutral face."""
    average = face.rig.neutral.vertices
    eyes = {side: eyeball(face, neutral, side) for side in ("Left", "Right")}
    made = _by_muscles if config.kind == "muscles" else _by_bent_units
    motion, basis, units = made(face, neutral, eyes, config, rng)
    performer = Performer(
        neutral=face.rig.neutral.with_vertices(neutral),
        names=face.rig.names,
        units=units,
        motion=motion,
        basis=basis,
        eyes=eyes,
        lids={side: lid_contact(face, eyeball(face, average, side), side, face.on_skin) for side in eyes},
        lips=lips,
        rigid=tuple(face.parts[p] for p in ("left_eye", "right_eye", "upper_teeth", "lower_teeth")),
        skin=face.on_skin,
    )
    if config.kind == "muscles":
        alone = performer.vertices(np.eye(len(performer.names))) - neutral
        return replace(performer, units=alone)
    return performer


def _by_muscles(
    face: BundledFace, neutral: np.ndarray, eyes: dict[str, Ball], config: PerformerConfig, rng: np.random.Generator
) -> tuple[MuscleMotion, np.ndarray, np.ndarray]:
    """Motion, basis, and units that are yet to be played."""
    where = SkinMap(face.rig.neutral.with_vertices(neutral), face)
    motion, basis = muscle_basis(where, eyes, config.muscles, config.style, rng)
    return motion, basis, np.zeros((len(face.rig.names), *neutral.shape))


def _by_bent_units(
    face: BundledFace, neutral: np.ndarray, eyes: dict[str, Ball], config: PerformerConfig, rng: np.random.Generator
) -> tuple[UnitMotion, np.ndarray, np.ndarray]:
    """Motion, basis and units of a person who bends the generic ones."""
    style, rig = config.style, face.rig.with_shapes(face.rig.neutral, face.fitted_deltas(neutral))
    generic = jaw_hinge(rig, face.parts["lower_teeth"])
    shift = (neutral - rig.neutral.vertices)[face.parts["lower_teeth"]].mean(axis=0) * [0, 1, 1]
    hinge = Hinge(generic.centre + shift, generic.angle * (1 + 0.5 * style.gain * float(np.clip(rng.normal(), -2, 2))))
    units = styled_units(rig, neutral, (generic, hinge), style, rng)
    bends = bows(rig, units, eyes, neutral, style, rng)
    jaw, close = (jaw_arcs(units[rig.index(name)], neutral, hinge) for name in ("jawOpen", "mouthClose"))
    pairs = interactions(rig.names, units, neutral, style, rng)
    motion = UnitMotion((rig.index("jawOpen"), rig.index("mouthClose")), hinge.angle, pairs)
    fields = np.concatenate([units, bends, np.stack([jaw[0], close[0], jaw[1], close[1]]), pairs.fields])
    return motion, fields.reshape(len(fields), -1), units
