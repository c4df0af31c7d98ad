"""Making performers: random people outside the identity space, each with a style of their own."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...faces.bundled import BundledFace, load_face
from .anatomy import Contact, Hinge, eyeball, jaw_hinge, lid_contact, lip_contact
from .fields import symmetric_field
from .holdout_identities import load_holdout_identities
from .performer import Performer, feature_basis, keep_off
from .style import VECTOR, StyleConfig, bows, interactions, jaw_arcs, styled_units

EYE_WINDOW = 22.0
"""Within this of an eye's centre (mm) the random field turns into a plain shift, so that lids still fit the ball."""


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
    style: StyleConfig = field(default_factory=StyleConfig)
    """How expressions differ from the generic units."""


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
    skin = np.zeros(len(shifted), dtype=bool)
    skin[face.parts["skin"]] = True
    lips = lip_contact(face, skin)
    neutral = _settle(face, shifted, lips, skin)
    return _assemble(face, neutral, skin, lips, config.style, rng_style)


def random_shape(
    face: BundledFace, config: PerformerConfig, rng: np.random.Generator
) -> Float[np.ndarray, "n 3"]:
    """Displacement of a random person's neutral face from the average one, mm."""
    coefficients = config.identity * np.clip(rng.normal(size=len(face.identity.modes)), -2, 2)
    shape = face.identity.displacement(coefficients)
    shape = shape + _holdout(config, rng)
    points = face.rig.neutral.vertices
    noise = symmetric_field(rng, points, (35.0, 110.0), VECTOR, asymmetry=0.35)
    noise *= config.displacement / np.sqrt((noise[face.parts["skin"]] ** 2).sum(axis=1).mean())
    for side in ("Left", "Right"):
        ball = eyeball(face, points, side)
        window = np.exp(-((np.linalg.norm(points - ball.centre, axis=1) / EYE_WINDOW) ** 4))[:, None]
        noise = (1 - window) * noise + window * noise[ball.vertices].mean(axis=0)
    for teeth in ("upper_teeth", "lower_teeth", "tongue"):
        noise[face.parts[teeth]] = noise[face.parts["upper_teeth"]].mean(axis=0)
    return shape + noise


def _holdout(config: PerformerConfig, rng: np.random.Generator) -> Float[np.ndarray, "n 3"]:
    """A random few of the targets that the identity space has never seen; of two ends of one slider, one."""
    names, targets = load_holdout_identities()
    chosen: dict[str, int] = {}
    for i in rng.permutation(len(names)):
        if len(chosen) < config.holdout_count:
            chosen.setdefault(names[i].rstrip("+-"), i)
    picked = np.array(sorted(chosen.values()), dtype=np.int64)
    return np.tensordot(config.holdout * rng.uniform(0.3, 1.0, len(picked)), targets[picked], axes=1)


def _settle(face: BundledFace, vertices: np.ndarray, lips: Contact, skin: np.ndarray) -> np.ndarray:
    """Close the lips and keep the lids outside the eyeballs."""
    vertices = vertices.copy()
    for _ in range(12):
        upper, lower = lips.points(vertices)
        half = ((upper - lower) * lips.normal).sum(axis=1)[:, None] * lips.normal / 2
        vertices[lips.vertices] += lips.follow_lower @ half - lips.follow_upper @ half
    usual = face.rig.neutral.vertices
    for side in ("Left", "Right"):
        ball, generic = eyeball(face, vertices, side), eyeball(face, usual, side)
        keep_off(vertices[None], usual - generic.centre + ball.centre, ball, skin)
    return vertices


def _assemble(
    face: BundledFace, neutral: np.ndarray, skin: np.ndarray, lips: Contact, style: StyleConfig,
    rng: np.random.Generator,
) -> Performer:
    """The performer on a finished neutral face."""
    rig = face.rig.with_shapes(face.rig.neutral, face.fitted_deltas(neutral))
    eyes = {side: eyeball(face, neutral, side) for side in ("Left", "Right")}
    lids = {side: lid_contact(face, eyeball(face, rig.neutral.vertices, side), side, skin) for side in eyes}
    generic = jaw_hinge(rig, face.parts["lower_teeth"])
    shift = (neutral - rig.neutral.vertices)[face.parts["lower_teeth"]].mean(axis=0) * [0, 1, 1]
    hinge = Hinge(generic.centre + shift, generic.angle * (1 + 0.5 * style.gain * float(np.clip(rng.normal(), -2, 2))))
    units = styled_units(rig, neutral, (generic, hinge), style, rng)
    bends = bows(rig, units, eyes, neutral, style, rng)
    jaw, close = (jaw_arcs(units[rig.index(name)], neutral, hinge) for name in ("jawOpen", "mouthClose"))
    pairs = interactions(rig, units, neutral, style, rng)
    return Performer(
        neutral=rig.neutral.with_vertices(neutral),
        names=rig.names,
        units=units,
        basis=feature_basis(units, bends, [jaw[0], close[0], jaw[1], close[1]], pairs),
        interactions=pairs,
        hinge=hinge,
        eyes=eyes,
        lids=lids,
        lips=lips,
        rigid=tuple(face.parts[p] for p in ("left_eye", "right_eye", "upper_teeth", "lower_teeth")),
        skin=skin,
    )
