"""A performance on another rig (Li et al. 2013, sec. 6), and what it takes to get there.

Coefficients go over by name. A shape that is only on one side of the bargain goes over through its parts: the 23
expressions of `FACS23` are sums of ARKit's. Correctives, the shapes that a tracker adds because the blendshapes cannot
say everything, have no counterpart: they are carried over by deformation transfer, past the paper.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import BadInput
from ..mesh import ClosestPoint, Mesh, face_areas, mass
from ..solve.boxls import box_least_squares
from .performance import Performance
from .rig import Rig
from .transfer import FACS23, nearest_faces, transfer_deltas

CORRECTIVE = "corrective"
"""What the names of corrective shapes begin with."""


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


def retarget(
    performance: Performance,
    target: Rig,
    correspondence: Int[np.ndarray, " target_faces"] | None = None,
    correctives: bool = True,
) -> Retargeted:
    """Drive `target` with a performance: coefficients by name, head pose as it is, correctives transferred.

    Args:
        correspondence: the source triangle that rules each target triangle; found by laying one face on the other
            where not given.
        correctives: False leaves them out, as the paper does.

    Raises:
        BadInput: the rigs have no shape in common.
    """
    source = performance.rig
    extra = np.array([name.startswith(CORRECTIVE) for name in source.names])
    weights, moved, dropped = by_name(source.names, performance.weights, target.names)
    if not moved:
        raise BadInput(
            f"the rigs have no shape in common (this one has {', '.join(source.names[:4])}, "
            f"the target {', '.join(target.names[:4]) or 'none'}); rename the target's shapes to ARKit's names"
        )
    used = extra & (np.abs(performance.weights).max(axis=0, initial=0.0) > 0)
    if correctives and used.any():
        target = _with_transferred(source, used, target, correspondence)
        weights = np.concatenate([weights, performance.weights[:, used]], axis=1)
    count = int(used.sum()) if correctives else 0
    return Retargeted(replace(performance, rig=target, weights=weights), moved, dropped, count)


def by_name(
    names: tuple[str, ...], weights: Float[np.ndarray, "frames shapes"], wanted: tuple[str, ...]
) -> tuple[Float[np.ndarray, "frames wanted"], tuple[str, ...], tuple[str, ...]]:
    """Coefficients in another order of names, through `FACS23` where one side has merged shapes and the other not.

    Returns them with the names that went over and those, used and not corrective, that found no place.
    """
    out, moved, dropped = np.zeros((len(weights), len(wanted))), [], []
    place = {name: i for i, name in enumerate(wanted)}
    whole = {part: (name, len(parts)) for name, parts in FACS23.items() for part in parts if len(parts) > 1}
    for i, name in enumerate(names):
        goals = [place[n] for n in ((name,) if name in place else FACS23.get(name, ())) if n in place]
        if goals:
            out[:, goals] += weights[:, i : i + 1]
        elif name in whole and whole[name][0] in place:
            out[:, place[whole[name][0]]] += weights[:, i] / whole[name][1]
        elif not name.startswith(CORRECTIVE) and np.abs(weights[:, i]).max(initial=0.0) > 0.01:
            dropped.append(name)
            continue
        else:
            continue
        moved.append(name)
    return out, tuple(moved), tuple(dropped)


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
    names = tuple(name for name, use in zip(source.names, used, strict=True) if use)
    return Rig(target.neutral, np.concatenate([target.deltas, deltas]), target.names + names, target.texture)


def _same(a: Mesh, b: Mesh) -> bool:
    return a.faces.shape == b.faces.shape and bool((a.faces == b.faces).all())
