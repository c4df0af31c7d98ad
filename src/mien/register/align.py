"""Find the face in a cloud of unnamed markers: similarity alignment to a face surface from many starts."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..mesh import ClosestPoint
from ..transforms import Transform, rotation_from_vector
from .rigid import procrustes, procrustes_frames
from .rigid_icp import closest_point_rounds

SETTLED_MM = 0.05
"""A round that moves no marker by more ends them."""


@dataclass(frozen=True)
class AlignConfig:
    """How the starts are spread, and how far each is followed."""

    turns: int = 12
    """Starting angles about the cloud's axis that is taken for the face's normal."""
    first: int = 8
    """Closest-point rounds that every start gets."""
    then: int = 40
    """... and at most this many more for the `followed` best of them."""
    followed: int = 10
    """How many starts are followed to the end."""
    keep: float = 0.85
    """Share of the markers, the closest ones, that pull (trimmed ICP)."""
    scale_range: float = 0.2
    """How far the similarity's scale may leave 1: the person's head is larger or smaller than the mean."""
    distinct_mm: float = 8.0
    """Two alignments that bring the markers this near, in the mean, are one."""
    most: int = 6
    """Distinct alignments handed on, best first."""


@dataclass(frozen=True)
class Alignment:
    """One way to lay the markers on the face."""

    T_face_head: Transform
    """Similarity: head frame of the take -> face space."""
    cost_mm: float
    """Trimmed rms distance to the surface, in the take's own millimetres."""


def align(
    cloud: Float[np.ndarray, "markers 3"], surface: ClosestPoint, config: AlignConfig = AlignConfig()
) -> list[Alignment]:
    """Distinct alignments of a calm frame's markers (mm) with a face surface (face space, mm), best first.

    Each principal axis of the cloud is tried as the face's normal, both ways, in `turns` angles; each start is
    followed by trimmed closest-point rounds with a bounded scale.
    """
    begun = _begin(cloud, surface, config)
    found = []
    for T in begun:
        followed = _follow(cloud, surface, T, config.then, config)
        found.append((followed, followed.T_face_head.apply(cloud)))
    found.sort(key=lambda pair: pair[0].cost_mm)
    distinct: list[tuple[Alignment, np.ndarray]] = []
    for alignment, placed in found:
        if all(np.linalg.norm(placed - other, axis=1).mean() > config.distinct_mm for _, other in distinct):
            distinct.append((alignment, placed))
    return [alignment for alignment, _ in distinct[: config.most]]


def starts(cloud: Float[np.ndarray, "markers 3"], turns: int) -> list[Float[np.ndarray, "3 3"]]:
    """Rotations that take each principal axis of the cloud, both ways, to +Z, in `turns` steps about it."""
    _, _, axes = np.linalg.svd(cloud - cloud.mean(axis=0), full_matrices=False)
    rotations = []
    for normal in np.concatenate([axes[::-1], -axes[::-1]]):
        side = np.linalg.svd(normal[None])[2][1]
        frame = np.stack([side, np.cross(normal, side), normal])
        rotations += [rotation_from_vector(np.array([0, 0, 2 * np.pi * i / turns])) @ frame for i in range(turns)]
    return rotations


def _begin(cloud: np.ndarray, surface: ClosestPoint, config: AlignConfig) -> list[Transform]:
    """A few rigid closest-point rounds of all starts at once; the most promising `followed`, best first."""
    R = np.stack(starts(cloud, config.turns))
    T = Transform(R, surface.mesh.vertices.mean(axis=0) - R @ cloud.mean(axis=0))
    many = np.broadcast_to(cloud, (len(R), *cloud.shape))
    distances = np.zeros(many.shape[:2])
    for _ in range(config.first):
        closest = surface.query(T.apply(many).reshape(-1, 3))
        distances = closest.distances.reshape(many.shape[:2])
        pull = distances <= np.quantile(distances, config.keep, axis=1, keepdims=True)
        T = procrustes_frames(many, closest.points.reshape(many.shape), pull.astype(float)).transform
    kept = np.sort(distances, axis=1)[:, : max(4, round(config.keep * len(cloud)))]
    return [T[i] for i in np.argsort((kept**2).mean(axis=1), kind="stable")[: config.followed]]


def _follow(cloud: np.ndarray, surface: ClosestPoint, T: Transform, iterations: int, config: AlignConfig) -> Alignment:
    few = max(4, round(config.keep * len(cloud)))

    def one_round(now: tuple[Transform, np.ndarray]) -> tuple[tuple[Transform, np.ndarray], bool]:
        T, _ = now
        moved = T.apply(cloud)
        closest = surface.query(moved)
        pull = (closest.distances <= np.partition(closest.distances, few - 1)[few - 1]).astype(float)
        T_new = procrustes(cloud, closest.points, pull, scale=True).transform
        size = float(np.clip(T_new.scale, 1 - config.scale_range, 1 + config.scale_range))
        if size != T_new.scale:
            scaled = procrustes(size * cloud, closest.points, pull).transform
            T_new = Transform(scaled.rotation, scaled.translation, size)
        return (T_new, closest.distances), bool(np.abs(T_new.apply(cloud) - moved).max() < SETTLED_MM)

    T, distances = closest_point_rounds((T, np.zeros(len(cloud))), one_round, iterations).state
    kept = np.sort(distances)[:few]
    return Alignment(T, float(np.sqrt((kept**2).mean())) / T.scale)
