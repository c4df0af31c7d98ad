"""What skin does between the markers: their motion carried by how shapes, and smooth skin, move together."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ..mesh import Attachment
from ..rig import Rig
from ..takes.motion_covariance import CovarianceConfig, MotionCovariance

BLINKS = ("eyeBlinkLeft", "eyeBlinkRight")


@dataclass(frozen=True)
class BetweenConfig:
    """How skin between the markers is expected to move, and how far that counts against the bundled shapes."""

    motion: CovarianceConfig = CovarianceConfig()
    most: float = 0.5
    """Largest share with which carried motion replaces the shapes' own, 0..1; 0 switches it off."""
    gain: float = 2.0
    """That share for each share of error that carried motion saves at markers left out."""
    lids: tuple[float, float] = (0.02, 0.15)
    """Where a blink moves skin by less than the first share of its most, all is carried; from the second on, nothing:
    no marker sees a lid."""


def carry_share(shapes_mm: float, carried_mm: float, config: BetweenConfig = BetweenConfig()) -> float:
    """How much carried motion counts, 0..`most`, by the error of shapes and of carried motion at markers left out."""
    if not (np.isfinite(shapes_mm) and np.isfinite(carried_mm) and shapes_mm > 0):
        return 0.0
    return float(np.clip(config.gain * (1 - carried_mm / shapes_mm), 0.0, config.most))


def carry_between_markers(
    rig: Rig,
    attachment: Attachment,
    covariance: MotionCovariance,
    skin: Int[np.ndarray, " k"],
    share: float,
    config: BetweenConfig = BetweenConfig(),
) -> Rig:
    """The rig whose shapes keep their motion at the markers, and between them are in part (`share`) carried from there.

    Eyes, teeth, tongue and lids keep their own.
    """
    D = attachment.matrix(rig.neutral)
    carry = covariance.carry(np.arange(len(attachment.faces)))
    where = np.zeros(len(rig.neutral.vertices))
    where[skin] = share
    where *= 1 - lid_mask(rig, config.lids)
    carried = np.einsum("vac,kc->kva", carry, np.stack([(D @ delta).ravel() for delta in rig.deltas]), optimize=True)
    return rig.with_shapes(rig.neutral, rig.deltas + where[:, None] * (carried - rig.deltas))


def lid_mask(rig: Rig, fades: tuple[float, float] = BetweenConfig.lids) -> Float[np.ndarray, " n"]:
    """1 on the lids, fading to 0 about them between two shares of a blink's most; 0 on a rig without blinks."""
    blinks = [rig.index(name) for name in BLINKS if name in rig.names]
    if not blinks:
        return np.zeros(len(rig.neutral.vertices))
    moved = np.linalg.norm(rig.deltas[blinks], axis=2).max(axis=0)
    low, high = fades
    return np.clip((moved / max(float(moved.max()), 1e-9) - low) / (high - low), 0.0, 1.0)
