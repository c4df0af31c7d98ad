"""Skin between the markers: where their motion is expected to carry it, by how shapes move with them.

A scan without colour tells little of where along itself skin has gone, and registration only where it bends least.
Scans that meet their markers therefore lean, along the skin, towards what shapes say of it. Not in the paper.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ...mesh import Attachment, closest_point, vertex_normals
from ...rig import Rig
from ...takes.motion_covariance import CovarianceConfig, motion_covariance
from ..scan_template import ScanTemplate


@dataclass(frozen=True)
class LeanConfig:
    """How far scans lean towards what the markers' motion says of the skin between them."""

    share: float = 0.4
    """Of the way along the skin, 0..1; 0: scans alone, as in the paper."""
    motion: CovarianceConfig = field(default_factory=lambda: CovarianceConfig(noise_mm=0.1))
    """A scan meets its markers exactly; they jitter by so much."""


def lean_on_markers(
    template: ScanTemplate,
    shapes: Float[np.ndarray, "scans n 3"],
    attachment: Attachment,
    config: LeanConfig = LeanConfig(),
) -> Float[np.ndarray, "scans n 3"]:
    """Scans that meet their markers, each moved along its skin part of the way to where the markers carry it.

    Args:
        shapes: the template's skin on each scan, the neutral one first, mm.
        attachment: markers' skin points on the template's skin.
    """
    if template.person is None or not config.share:
        return shapes
    D, rest = attachment.matrix(template.skin), shapes[0]
    on_person = closest_point(template.person.neutral, template.skin.vertices).attachment()
    carry = carried_by_markers(template.person, D @ rest, config.motion)
    out = shapes.copy()
    for i, shape in enumerate(shapes[1:], 1):
        motion = carry @ (D @ (shape - rest)).ravel()
        off = rest + on_person.points(template.person.neutral.with_vertices(motion)) - shape
        out[i] = shape + config.share * along_skin(off, vertex_normals(shape, template.skin.faces))
    return out


def carried_by_markers(
    person: Rig, markers: Float[np.ndarray, "k 3"], config: CovarianceConfig
) -> Float[np.ndarray, "n 3 k3"]:
    """The matrix from the motion of points of a person's skin to that of all its vertices.

    Args:
        markers: the points, on the person's neutral, mm.
    """
    on_person = closest_point(person.neutral, markers).attachment()
    everywhere = np.arange(len(person.neutral.vertices))
    return motion_covariance(person, on_person, everywhere, config).carry(np.arange(len(markers)))


def along_skin(vectors: Float[np.ndarray, "n 3"], normals: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """What of vectors at a surface's vertices lies along it."""
    return vectors - np.einsum("nd,nd->n", vectors, normals)[:, None] * normals
