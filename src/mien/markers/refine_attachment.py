"""Move attachments along the skin to where the skin moves as the markers do."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ..fitting.marker_identity import IdentityFit
from ..fitting.terms import surface_points
from ..mesh import Attachment, vertex_normals
from ..rig import Rig

INSET = 0.15
"""Barycentric coordinates of the two far corners of a candidate that lies near the third."""
FEWEST_FRAMES = 10
"""A marker that is seen in fewer frames keeps its place: its motion cannot be compared."""


@dataclass(frozen=True)
class RefineConfig:
    """What a place on the skin is judged by."""

    radius_mm: float = 9.0
    """How far from its present place a marker is looked for."""
    motion: float = 1.0
    """Weight of the mean squared mismatch of motion, per mm^2."""
    along: float = 0.02
    """Weight of the squared distance along the skin, in the calm frame, per mm^2: identity is uncertain there."""
    out: float = 0.3
    """... and of that along the normal."""


def refine_attachment(
    rig: Rig,
    fit: IdentityFit,
    region: np.ndarray,
    weights: Float[np.ndarray, "frames shapes"],
    targets: Float[np.ndarray, "frames markers 3"],
    used: Bool[np.ndarray, "frames markers"],
    rest: Float[np.ndarray, "markers 3"],
    config: RefineConfig = RefineConfig(),
) -> Attachment:
    """The best place within reach for every marker, over all frames (`targets`, and `rest` of the calm frame, in face
    space, mm).

    Every triangle of the region lends four candidates (three inset corners and the centre). A candidate's motion
    mismatch over the take is a quadratic form in its shapes, so no frame is visited twice.
    """
    mesh = rig.neutral
    corner, centre = np.full((3, 3), INSET) + (1 - 3 * INSET) * np.eye(3), np.full((1, 3), 1 / 3)
    inside = np.concatenate([corner, centre])
    triangles = np.repeat(region, len(inside))
    candidates = Attachment(triangles, np.tile(inside, (len(region), 1)))
    places = surface_points(mesh, candidates, fit.standoff_mm)
    present = surface_points(mesh, fit.attachment, fit.standoff_mm)
    normals = vertex_normals(mesh.vertices, mesh.faces)[mesh.faces[triangles]].mean(axis=1)
    D = candidates.matrix(mesh)
    shapes = np.stack([D @ delta for delta in rig.deltas])
    faces, barycentric = fit.attachment.faces.copy(), fit.attachment.barycentric.copy()
    for i in range(targets.shape[1]):
        near = np.flatnonzero(np.linalg.norm(places - present[i], axis=1) < config.radius_mm)
        frames = used[:, i]
        if len(near) == 0 or frames.sum() < FEWEST_FRAMES:
            continue
        centred = weights[frames] - weights[frames].mean(axis=0)
        target = targets[frames, i]
        cost = config.motion * _motion_mismatch(centred, target - target.mean(axis=0), shapes[:, near])
        apart = rest[i] - places[near]
        out = (apart * normals[near]).sum(axis=1) ** 2
        cost += config.out * out + config.along * ((apart**2).sum(axis=1) - out)
        best = near[np.argmin(cost)]
        faces[i], barycentric[i] = candidates.faces[best], candidates.barycentric[best]
    return Attachment(faces, barycentric)


def _motion_mismatch(weights: np.ndarray, motion: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """mean_t |motion_t - sum_k w_tk shapes_k|^2 for every candidate, from second moments alone. mm^2."""
    t = len(weights)
    own = (motion**2).sum() / t
    cross = weights.T @ motion / t
    gram = weights.T @ weights / t
    squared = np.einsum("kcd,kl,lcd->c", shapes, gram, shapes, optimize=True)
    return own - 2 * np.einsum("kd,kcd->c", cross, shapes) + squared
