"""What skin does between the markers: their motion carried by how shapes, and smooth skin, move together."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ..mesh import Attachment
from ..register.interpolate import green_functions
from ..rig import Rig

BLINKS = ("eyeBlinkLeft", "eyeBlinkRight")


@dataclass(frozen=True)
class BetweenConfig:
    """How skin between the markers is expected to move, and how far that counts against the bundled shapes."""

    shape_deviation: float = 0.5
    """Expected deviation of a shape's weight; shapes move near skin alike and far skin each for itself."""
    near_mm: float = 30.0
    """Distance over which a shape's weight is alike, mm: a performer plays a shape otherwise elsewhere."""
    alike: float = 0.2
    """Share of a weight's variance that is common to the whole face, 0..1."""
    smooth_mm: float = 2.0
    """Expected deviation of smooth motion that no shape has, mm."""
    reach_mm: float = 30.0
    """Such motion fades beyond about so far from a marker, mm."""
    noise_mm: float = 0.15
    """What a marker may be off by itself, mm: jitter."""
    most: float = 0.5
    """Largest share with which carried motion replaces the shapes' own, 0..1; 0 switches it off."""
    gain: float = 2.0
    """That share for each share of error that carried motion saves at markers left out."""
    lids: tuple[float, float] = (0.02, 0.15)
    """Where a blink moves skin by less than the first share of its most, all is carried; from the second on, nothing:
    no marker sees a lid."""


@dataclass(frozen=True)
class MotionCovariance:
    """How the motion of skin goes with that of markers, before any was seen: mm^2."""

    skin: Float[np.ndarray, "n 3 markers 3"]
    markers: Float[np.ndarray, "markers 3 markers 3"]
    noise_mm: float

    def carry(
        self, shown: Int[np.ndarray, " s"], hidden: Int[np.ndarray, " h"] | None = None
    ) -> Float[np.ndarray, "k 3 s3"]:
        """The matrix from the shown markers' motion, (s * 3), to that of all vertices, or of the hidden markers.

        The expected motion given theirs: C_vs (C_ss + noise)^-1 (kriging; a Gaussian process's mean).
        """
        to = self.skin if hidden is None else self.markers[hidden]
        count = 3 * len(shown)
        known = self.markers[shown][:, :, shown].reshape(count, count)
        across = to[:, :, shown].reshape(-1, count)
        carried = np.linalg.solve(known + self.noise_mm**2 * np.eye(count), across.T).T
        return carried.reshape(len(to), 3, count)


def motion_covariance(
    rig: Rig, attachment: Attachment, skin: Int[np.ndarray, " k"], config: BetweenConfig = BetweenConfig()
) -> MotionCovariance:
    """How skin moves with markers: shapes whose weights vary over the face, and a thin plate's bending on `skin`.

    Shapes alone would have everybody smile alike; a spline alone knows nothing of lips, jaws and lids. Each shape's
    weight is a random field here, of correlation alike + (1 - alike) exp(-d^2 / 2 near^2).
    """
    D = attachment.matrix(rig.neutral)
    vertices, places = rig.neutral.vertices, attachment.points(rig.neutral)
    at_markers = np.stack([D @ delta for delta in rig.deltas])
    apart = ((vertices[:, None] - places[None]) ** 2).sum(axis=2)
    together = config.alike + (1 - config.alike) * np.exp(-apart / (2 * config.near_mm**2))
    by_shapes = np.einsum("kva,kmb->vamb", rig.deltas, at_markers, optimize=True)
    covariance = by_shapes * (config.shape_deviation**2 * together)[:, None, :, None]
    bent = green_functions(rig.neutral, D, config.reach_mm, skin)
    bent *= config.smooth_mm**2 / np.mean(np.diag(D @ bent))
    for axis in range(3):
        covariance[:, axis, :, axis] += bent
    count = len(places)
    known = (D @ covariance.reshape(len(vertices), -1)).reshape(count, 3, count, 3)
    return MotionCovariance(covariance, (known + known.transpose(2, 3, 0, 1)) / 2, config.noise_mm)


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
