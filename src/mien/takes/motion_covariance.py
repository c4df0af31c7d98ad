"""How the motion of skin goes with that of markers: by how shapes, and smooth skin, move together."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ..mesh import Attachment
from ..register.interpolate import green_functions
from ..rig import Rig


@dataclass(frozen=True)
class CovarianceConfig:
    """How skin is expected to move before any marker was seen."""

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
    rig: Rig, attachment: Attachment, skin: Int[np.ndarray, " k"], config: CovarianceConfig = CovarianceConfig()
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
