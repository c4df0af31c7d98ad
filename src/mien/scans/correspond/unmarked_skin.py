"""Skin that no marker is near: where it is expected to have gone, by how shapes move with the markers.

Below the chin and at the temples a scan is smooth and has no markers: nothing but the stiffness of the template would
say where along it the skin has gone. Not in the paper.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import KDTree

from ...mesh import Attachment, closest_point
from ...register import Anchors
from ...takes.motion_covariance import CovarianceConfig
from ..scan_template import ScanTemplate
from .carried_skin import carried_by_markers


@dataclass(frozen=True)
class UnmarkedConfig:
    """Which skin counts as unmarked, and how far its expected motion counts."""

    weight: float = 0.1
    """Of each expected place, on the scale of `LargeScaleConfig.landmarks`; 0: none, as in the paper."""
    far_mm: float = 12.0
    """Skin farther than this from every marker is unmarked."""
    off_edges_mm: float = 10.0
    """... and so far from lips and lids, which scans and landmarks tell."""
    motion: CovarianceConfig = field(default_factory=lambda: CovarianceConfig(noise_mm=0.4))
    """A marker is off by so much on a scan: it is laid on it by closest points."""


def unmarked_anchors(
    template: ScanTemplate,
    attachment: Attachment,
    skin_points: Float[np.ndarray, "markers 3"],
    covered: Bool[np.ndarray, " markers"],
    config: UnmarkedConfig,
    scale: float,
) -> Anchors | None:
    """Points of the template far from markers, and where the markers' motion carries them; None where there are none.

    Args:
        attachment: markers' skin points on the template's skin.
        skin_points: where they are on the scan, face space, mm.
        covered: markers that count.
        scale: of an anchor's weight, for a `config.weight` of 1.
    """
    person = template.person
    if person is None or not config.weight or not covered.any():
        return None
    before = attachment.points(template.skin)[covered]
    far = _unmarked(template, person.neutral.vertices, before, config)
    if not far.any():
        return None
    carry = carried_by_markers(person, before, config.motion)
    moved = skin_points[covered] - before
    expected = person.neutral.vertices + carry @ moved.ravel()
    on_template = closest_point(template.skin, person.neutral.vertices[far]).attachment()
    weights = np.full(int(far.sum()), config.weight * scale)
    return Anchors(on_template, expected[far], weights)


def _unmarked(
    template: ScanTemplate,
    vertices: Float[np.ndarray, "n 3"],
    markers: Float[np.ndarray, "k 3"],
    config: UnmarkedConfig,
) -> Bool[np.ndarray, " n"]:
    """Which of the vertices are on skin that scans show, far from the markers and from the edges of lips and lids."""
    there = closest_point(template.skin, vertices)
    corner = template.skin.faces[there.faces, there.barycentric.argmax(axis=1)]
    far = KDTree(markers).query(vertices)[0] > config.far_mm
    edges = template.skin.vertices[template.sides != 0]
    if len(edges):
        far &= KDTree(edges).query(vertices)[0] > config.off_edges_mm
    return far & template.shown[corner]
