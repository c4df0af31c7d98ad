"""Markers on a face that had none: points of the surface as a marker take, for programs that solve from markers."""

from collections.abc import Sequence

import numpy as np

from ..clip import Markers
from ..mesh import Attachment, connected_parts
from .performance import Performance
from .rig import Rig

_MOVES = 0.05
"""The face is what some shape moves by more than this share of the largest displacement."""


def sample_markers(rig: Rig, count: int) -> Attachment:
    """So many vertices of the moving skin, each as far from those before it as can be (farthest-point sampling).

    The skin is the connected part with most moving vertices: neither eyeballs nor teeth.

    Raises:
        ValueError: fewer than one, or more than the skin has vertices.
    """
    vertices, faces = rig.neutral.vertices, rig.neutral.faces
    moves = np.linalg.norm(rig.deltas, axis=2).max(axis=0, initial=0.0)
    moving = moves > _MOVES * moves.max(initial=0.0)
    part = connected_parts(faces, len(vertices))
    skin = part == np.bincount(part[moving], minlength=1).argmax() if moving.any() else np.isin(part, part[faces[:1]])
    ground = np.flatnonzero(skin & moving if moving.any() else skin)
    if not 0 < count <= len(ground):
        raise ValueError(f"count: expected 1..{len(ground)}, the vertices of the skin that moves, got {count}")
    chosen = [int(ground[vertices[ground, 2].argmax()])]
    far = np.linalg.norm(vertices[ground] - vertices[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(ground[far.argmax()]))
        far = np.minimum(far, np.linalg.norm(vertices[ground] - vertices[chosen[-1]], axis=1))
    return _at_vertices(faces, chosen)


def virtual_markers(performance: Performance, attachment: Attachment, labels: Sequence[str]) -> Markers:
    """The points in every frame, in the take's world, millimetres; frames that were not tracked are gaps."""
    rig = performance.rig
    matrix = attachment.matrix(rig.neutral)
    neutral = attachment.points(rig.neutral)
    shifts = np.stack([matrix @ delta for delta in rig.deltas]) if len(rig.deltas) else np.zeros((0, *neutral.shape))
    in_face = neutral + np.einsum("tk,kpd->tpd", performance.weights, shifts)
    positions = performance.T_world_face.apply(in_face)
    positions[~performance.tracked] = np.nan
    return Markers(positions, tuple(labels), performance.rate)


def _at_vertices(faces: np.ndarray, chosen: list[int]) -> Attachment:
    """Each vertex as a corner of the first triangle that has it."""
    flat = faces.ravel()
    first = np.array([int(np.flatnonzero(flat == vertex)[0]) for vertex in chosen])
    face, corner = np.divmod(first, 3)
    return Attachment(face, np.eye(3)[corner])
