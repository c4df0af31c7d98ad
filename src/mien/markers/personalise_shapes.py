"""Bend a rig's shapes to the performer, by what the markers did over a whole take."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ..mesh import Attachment, Mesh
from ..register.interpolate import interpolate_from_points
from ..rig import Rig
from ..takes.marker_model import MarkerModel


@dataclass(frozen=True)
class PersonaliseConfig:
    """How far the performer's shapes may differ from the rig's."""

    own_share: float = 0.4
    """Prior deviation of a shape's displacement at a marker, as a share of that displacement."""
    body_share: float = 0.1
    """... plus this share of the shape's rms displacement over all markers, where the shape itself is still."""
    neutral_mm: float = 1.0
    """Prior deviation of the neutral face at a marker, mm; 0 leaves the neutral alone."""
    noise_mm: float = 0.3
    """What a marker may do besides, mm: jitter, and motion that no shape has."""
    independent_hz: float = 8.0
    """How many frames a second count as independent samples."""
    reach_mm: float = 17.0
    """A correction at a marker fades beyond about so far from it, mm."""
    stiffness_mm2: float = 0.14
    """How much of a correction's roughness between neighbouring markers is smoothed away, mm^2; 0: none."""


def shape_corrections(
    model: MarkerModel,
    weights: Float[np.ndarray, "frames shapes"],
    targets: Float[np.ndarray, "frames markers 3"],
    used: Bool[np.ndarray, "frames markers"],
    rate: float,
    config: PersonaliseConfig = PersonaliseConfig(),
) -> tuple[Float[np.ndarray, "markers 3"], Float[np.ndarray, "shapes markers 3"]]:
    """Corrections to the neutral and to every shape at the markers, mm: ridge regression, marker by marker.

    `targets` are the markers in face space. The prior of a correction grows with the shape's own displacement, so a
    shape that does not move a marker hardly starts to.
    """
    neutral_prior, shape_prior = _priors(model, config)
    deviation = np.vstack([np.broadcast_to(neutral_prior, (1, len(model.neutral))), shape_prior])
    W = np.c_[np.ones(len(weights)), weights]
    noise = config.noise_mm**2 * max(1.0, rate / config.independent_hz)
    residual = np.nan_to_num(targets - model.points(weights))
    corrections = np.zeros((W.shape[1], len(model.neutral), 3))
    for i in range(len(model.neutral)):
        V = W[used[:, i]] * deviation[:, i]
        gram = V.T @ V + noise * np.eye(V.shape[1])
        solved = np.linalg.solve(gram, V.T @ residual[used[:, i], i])
        corrections[:, i] = deviation[:, i, None] * solved
    return corrections[0], corrections[1:]


def personalise_shapes(
    rig: Rig,
    attachment: Attachment,
    neutral_correction: Float[np.ndarray, "markers 3"],
    shape_correction: Float[np.ndarray, "shapes markers 3"],
    S: Float[np.ndarray, "n markers"],
    config: PersonaliseConfig = PersonaliseConfig(),
) -> Rig:
    """The rig with corrections at the markers spread smoothly over the skin by `S` (see `spline`).

    A shape's correction is spread as a share of how much the shape may vary there (see `PersonaliseConfig`): it
    fades where the shape itself does not move.
    """
    D = attachment.matrix(rig.neutral)
    neutral = rig.neutral.with_vertices(rig.neutral.vertices + S @ neutral_correction)
    deltas = rig.deltas.copy()
    for k, delta in enumerate(rig.deltas):
        at_markers = np.linalg.norm(D @ delta, axis=1)
        body = config.body_share * np.sqrt((at_markers**2).mean())
        here = config.own_share * at_markers + body
        everywhere = config.own_share * np.linalg.norm(delta, axis=1) + body
        if body > 1e-6:
            deltas[k] += everywhere[:, None] * (S @ (shape_correction[k] / here[:, None]))
    return rig.with_shapes(neutral, deltas)


def spline(
    mesh: Mesh, attachment: Attachment, skin: Int[np.ndarray, " k"], config: PersonaliseConfig = PersonaliseConfig()
) -> Float[np.ndarray, "n markers"]:
    """The spline S from values at the markers to every vertex, zero off the skin and far away."""
    return interpolate_from_points(mesh, attachment, config.reach_mm, config.stiffness_mm2, skin)


def _priors(model: MarkerModel, config: PersonaliseConfig) -> tuple[np.ndarray, np.ndarray]:
    size = np.linalg.norm(model.shapes, axis=2)
    body = np.sqrt((size**2).mean(axis=1, keepdims=True))
    return np.array(config.neutral_mm), config.own_share * size + config.body_share * body
