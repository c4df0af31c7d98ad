"""How well scans in one topology meet what a user says corresponds on them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ...image_space.constraints import PairConstraint
from ...mesh import Mesh, closest_point
from ...one_line import count


@dataclass(frozen=True)
class PairsMet:
    """Pairs by hand, and how far they are from each other before and after they are asked for."""

    scans: Int[np.ndarray, "pairs 2"]
    """By number."""
    names: tuple[str, ...]
    """What each is among those of its two scans: `point 2`, `curve 1`."""
    before: Float[np.ndarray, " pairs"]
    """Millimetres along the topology, see `pair_distances`."""
    after: Float[np.ndarray, " pairs"]

    def told(self, scan_names: Sequence[str]) -> str:
        """A line, with the worst pair by its name."""
        worst = int(self.after.argmax())
        first, second = self.scans[worst].tolist()
        return (
            f"{count(len(self.names), 'pairs')} by hand: {self.before.mean():.2f} mm off before, "
            f"{self.after.mean():.2f} mm now; the worst is {self.names[worst]} of {scan_names[first]} and "
            f"{scan_names[second]} ({self.before[worst]:.2f} mm before, {self.after[worst]:.2f} mm now)"
        )


def pairs_met(
    constraints: Sequence[PairConstraint],
    faces: Int[np.ndarray, "m 3"],
    before: Float[np.ndarray, "scans n 3"],
    after: Float[np.ndarray, "scans n 3"],
) -> PairsMet:
    """How well shapes meet the constraints (face space, mm) before and after."""
    scans, names, off = [], [], []
    for constraint in constraints:
        points, curves = constraint.points.shape[1], len(constraint.curves)
        scans += [constraint.scans] * (points + curves)
        names += [f"point {i + 1}" for i in range(points)]
        names += [f"curve {i + 1}" for i in range(curves)]
        off.append([pair_distances(constraint, shapes, faces) for shapes in (before, after)])
    return PairsMet(np.array(scans), tuple(names), *np.concatenate(off, axis=1))


def pair_distances(
    constraint: PairConstraint, shapes: Float[np.ndarray, "scans n 3"], faces: Int[np.ndarray, "m 3"]
) -> Float[np.ndarray, " pairs"]:
    """How far places of the first scan, carried by the topology to the second, are from where they belong, mm.

    The points, then the curves: the mean over the corners of the first line of how far they are from the second line.
    """
    first, second = (Mesh(shapes[i], faces) for i in constraint.scans)

    def carried(points: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "k 3"]:
        return closest_point(first, points).attachment().points(second)

    one, other = constraint.points
    points = np.linalg.norm(carried(one) - other, axis=1) if len(one) else np.zeros(0)
    curves = [distance_to_line(carried(line), along).mean() for line, along in constraint.curves]
    return np.concatenate([points, curves])


def distance_to_line(points: Float[np.ndarray, "k 3"], line: Float[np.ndarray, "corners 3"]) -> Float[np.ndarray, " k"]:
    """From each point to the nearest place of a polyline, in the unit of both."""
    start, along = line[:-1], np.diff(line, axis=0)
    from_start = points[:, None] - start
    share = (from_start * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    nearest = start + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
