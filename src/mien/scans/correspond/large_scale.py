"""Large-scale registration: the template deformed to every scan (Huang et al. 2011, sec. 6.1, eq. 7).

Beside the paper: lips and lids, which have few markers or none, are held by landmarks, on the template where the
detector saw them on the neutral scan, so that its own bias takes itself off; the two lips, or lids of an eye, never
match each other, nor the eyeballs; and skin that no marker is near is held where it is expected (`unmarked_skin`).
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from ...fitting.register_scan import LIPS_AND_LIDS
from ...fitting.skin_pieces import skin_pieces
from ...landmarks.detector import bundled_landmarks
from ...mesh import Attachment, Mesh, closest_point
from ...register import Anchors, NonrigidConfig, Surface
from ..scan_template import ScanTemplate
from .unmarked_skin import UnmarkedConfig, unmarked_anchors


@dataclass(frozen=True)
class LargeScaleConfig:
    """The large-scale step (sec. 6.1, eq. 7), with the paper's weights but w2."""

    nonrigid: NonrigidConfig = field(default_factory=lambda: NonrigidConfig(coarse=(), laplacian=5.0, plane=1.0))
    """w1 = 10000, w3 = 0.1, 0.5, 2 as in the paper; w2 = 5 where it has 1, since points slide along the scan freely."""
    landmarks: float = 0.1
    """Weight of lip and lid landmarks, against `nonrigid.markers` of a marker; 0: none, as in the paper."""
    landmark_slack: float = 1.5
    """A landmark on which the views disagree by this much counts half, mm."""
    unmarked: UnmarkedConfig = UnmarkedConfig()
    """Where skin is expected that no marker is near."""


@dataclass(frozen=True)
class ScanLandmarks:
    """Lips and lids as a detector sees them on a scan."""

    points: Float[np.ndarray, "478 3"]
    """Face space, mm; NaN where not seen."""
    disagreement: Float[np.ndarray, " 478"]
    """How far the views disagree, mm."""


@dataclass(frozen=True)
class LargeScaleTarget:
    """What the template is deformed to: a scan, its markers, and what is seen on it."""

    mesh: Mesh
    """Face space, mm."""
    skin_points: Float[np.ndarray, "markers 3"]
    """Points of its skin under the markers."""
    covered: Bool[np.ndarray, " markers"]
    """Markers that count."""
    landmarks: tuple[ScanLandmarks, ScanLandmarks] | None
    """On the neutral scan and on this one."""


def register(
    template: ScanTemplate,
    attachment: Attachment,
    target: LargeScaleTarget,
    config: LargeScaleConfig = LargeScaleConfig(),
) -> Float[np.ndarray, "n 3"]:
    """The template's skin on one scan: eq. 7, markers to markers, then the surface three times, ever more firmly.

    Args:
        attachment: markers' skin points on the template's skin.
    """
    anchors = Anchors(attachment, target.skin_points, target.covered.astype(float))
    if target.landmarks is not None and config.landmarks:
        anchors = _joined(anchors, _landmark_anchors(template, *target.landmarks, config))
    scale = 1 / config.nonrigid.markers
    expected = unmarked_anchors(template, attachment, target.skin_points, target.covered, config.unmarked, scale)
    if expected is not None:
        anchors = _joined(anchors, expected)
    skin = skin_pieces(target.mesh, template.mesh, template.in_the_open)
    found = template.body.register(Surface(skin), anchors, config.nonrigid, trust=template.trust, sides=template.sides)
    return found.vertices.astype(np.float32).astype(np.float64)


def _landmark_anchors(
    template: ScanTemplate, neutral: ScanLandmarks, here: ScanLandmarks, config: LargeScaleConfig
) -> Anchors:
    groups = bundled_landmarks().groups
    used = np.unique(np.concatenate([groups[name] for name in LIPS_AND_LIDS]))
    used = used[np.isfinite(neutral.points[used]).all(axis=1) & np.isfinite(here.points[used]).all(axis=1)]
    on_template = closest_point(template.skin, neutral.points[used]).attachment()
    disagreement = neutral.disagreement[used] ** 2 + here.disagreement[used] ** 2
    weights = config.landmarks / config.nonrigid.markers / (1 + disagreement / config.landmark_slack**2)
    return Anchors(on_template, here.points[used], weights)


def _joined(a: Anchors, b: Anchors) -> Anchors:
    attachment = Attachment(
        np.concatenate([a.attachment.faces, b.attachment.faces]),
        np.concatenate([a.attachment.barycentric, b.attachment.barycentric]),
    )
    return Anchors(attachment, np.concatenate([a.points, b.points]), np.concatenate([a.weights, b.weights]))
