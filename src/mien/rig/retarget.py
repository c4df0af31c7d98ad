"""A performance on another rig (Li et al. 2013, sec. 6), and what it takes to get there.

Coefficients go over by name (`shape_names`). Correctives, the shapes that a tracker adds because the blendshapes cannot
say everything, have no counterpart: they are carried over by deformation transfer, past the paper.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import BadInput
from ..mesh import ClosestPoint, Mesh, face_areas, mass
from ..one_line import count, one_line
from ..solve.boxls import box_least_squares
from .head_place import HeadPlace, find_head, place_motion
from .performance import Performance
from .rig import Rig
from .shape_names import USED, NameMatch, match_names
from .transfer import nearest_faces, transfer_deltas
from .unit_weights import CORRECTIVE


@dataclass(frozen=True)
class Retargeted:
    """A performance on its new rig, and what became of the shapes."""

    performance: Performance
    moved: tuple[str, ...]
    """Shapes whose coefficients went over."""
    dropped: tuple[str, ...]
    """Shapes in use that the target has nothing for."""
    correctives: int
    """Corrective shapes transferred."""
    notes: tuple[str, ...]
    """What was matched loosely, what is missing, how the head was placed: a line each."""

    def __repr__(self) -> str:
        moved = f"{len(self.moved)} shapes moved, {len(self.dropped)} dropped"
        return one_line(self, moved, count(self.correctives, "correctives"), self.performance)


def retarget(
    performance: Performance,
    target: Rig,
    correspondence: Int[np.ndarray, " target_faces"] | None = None,
    correctives: bool = True,
    given: Mapping[str, str] | None = None,
    head: HeadPlace | None = None,
) -> Retargeted:
    """Drive `target` with a performance: coefficients by name, the head in its own place, correctives transferred.

    Args:
        correspondence: the source triangle that rules each target triangle; found by laying one face on the other
            where not given.
        correctives: False leaves them out, as the paper does.
        given: pairs of names by hand (`match_names`).
        head: where the target's head is; found from its shapes where not given.

    Raises:
        BadInput: the rigs have no shape in common.
    """
    source = performance.rig
    is_corrective = np.array([name.startswith(CORRECTIVE) for name in source.names])
    match = match_shapes(performance.rig.names, target.names, given)
    weights = match.weights(performance.weights[:, ~is_corrective])
    peak = np.abs(performance.weights).max(axis=0, initial=0.0)
    dropped = tuple(name for name in match.missing if peak[source.index(name)] > USED)
    T_rig, notes = place_motion(performance.T_world_face, find_head(target) if head is None else head)
    used = is_corrective & (peak > 0) & correctives
    if used.any():
        target = _with_transferred(source, used, target, correspondence)
        weights = np.concatenate([weights, performance.weights[:, used]], axis=1)
    played = replace(performance, rig=target, weights=weights, T_world_face=T_rig)
    return Retargeted(played, match.moved, dropped, int(used.sum()), (*match.notes(), *notes))


def match_shapes(sources: Sequence[str], targets: Sequence[str], given: Mapping[str, str] | None = None) -> NameMatch:
    """`match_names` of the source's shapes, correctives aside, and all of the target's.

    Raises:
        BadInput: nothing in common.
    """
    own = [name for name in sources if not name.startswith(CORRECTIVE)]
    match = match_names(own, targets, given)
    if not match.moved:
        raise BadInput(
            f"the rigs have no shape in common (this one has {', '.join(own[:4])}, the target "
            f"{', '.join(targets[:4]) or 'none'}); name pairs in a file for --map, or rename to ARKit's names"
        )
    return match


def resolve_weights(
    rig: Rig, vertices: Float[np.ndarray, "frames n 3"], mask: Float[np.ndarray, " n"] | None = None, ridge: float = 0.0
) -> Float[np.ndarray, "frames shapes"]:
    """Coefficients in 0..1 that bring `rig` closest to given shapes (mm), every vertex by its area times `mask`.

    `ridge` is the weight of a squared coefficient against mean squared distance, mm^2.
    """
    share = mass(rig.neutral.vertices, rig.neutral.faces) * (1.0 if mask is None else mask)
    share = share / share.sum()
    used = share > 0
    flat = (rig.deltas[:, used] * np.sqrt(share[used])[:, None]).reshape(len(rig.names), -1)
    gram = flat @ flat.T + ridge * np.eye(len(rig.names))
    offsets = (vertices - rig.neutral.vertices)[:, used] * np.sqrt(share[used])[:, None]
    return box_least_squares(gram, offsets.reshape(len(vertices), -1) @ flat.T).values


def lay_over(source: Mesh, target: Mesh) -> Mesh:
    """The target, turned to nothing but scaled and shifted onto the source: both in face space, eyes ahead.

    The skins' sizes (root of area) and middles are made equal, then closest points settle scale and shift: enough for
    faces of one kind to lie on one another, so that `nearest_faces` finds what belongs together.
    """
    ratio = np.sqrt(face_areas(source.vertices, source.faces).sum() / face_areas(target.vertices, target.faces).sum())
    vertices = (target.vertices - _middle(target)) * ratio + _middle(source)
    tree = ClosestPoint(source)
    for _ in range(20):
        found = tree.query(vertices)
        near = found.distances <= np.quantile(found.distances, 0.8)
        a, b = vertices[near], found.points[near]
        spread = ((a - a.mean(0)) ** 2).sum()
        scale = float(((a - a.mean(0)) * (b - b.mean(0))).sum() / spread)
        vertices = (vertices - a.mean(0)) * scale + b.mean(0)
    return target.with_vertices(vertices)


def _middle(mesh: Mesh) -> np.ndarray:
    """Middle of the forward half, which heads with and without necks have alike."""
    front = mesh.vertices[mesh.vertices[:, 2] > np.median(mesh.vertices[:, 2])]
    return (front.min(0) + front.max(0)) / 2


def _with_transferred(source: Rig, used: Bool[np.ndarray, " shapes"], target: Rig, correspondence) -> Rig:
    """The target with the used correctives of the source behind its own shapes."""
    if correspondence is None and not _same(source.neutral, target.neutral):
        correspondence = nearest_faces(source.neutral, lay_over(source.neutral, target.neutral))
    deltas = transfer_deltas(source.neutral, source.deltas[used], target.neutral, correspondence)
    names, taken = [], set(target.names)
    for name in (name for name, use in zip(source.names, used, strict=True) if use):
        names.append(next(n for n in (name, *(f"{name}_{i}" for i in range(2, 1000))) if n not in taken))
        taken.add(names[-1])
    return Rig(target.neutral, np.concatenate([target.deltas, deltas]), (*target.names, *names), target.texture)


def _same(a: Mesh, b: Mesh) -> bool:
    return a.faces.shape == b.faces.shape and bool((a.faces == b.faces).all())
