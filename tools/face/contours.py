"""The edges of lids and lips on the face, and two repairs along them: eyeballs seated, lips closed."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from mien.mesh import Mesh, closest_point, face_normals

from .layout import MILLIMETRES, Layout
from .regions import step
from .rings import QuadNet, arcs

LID = (13352, 13353)
"""An edge of the base on the ring that bounds the left eye's opening as seen from the front."""
LASHES = ((6784, 6790), (11465, 11466))
"""The next rings outwards."""
LIPS = {(541, 545): 0.4, (524, 528): 0.8, (420, 436): 1.0, (418, 433): 1.0, (416, 417): 0.9, (497, 504): 0.7,
        (414, 427): 0.5, (412, 413): 0.3, (402, 3737): 0.15}
"""Rings round the mouth from the inside out, by an edge each; how far each moves when the lips close."""
SEAM = ((524, 528), (420, 436), (418, 433))
"""Those rings of which one is the lips' edge as seen from the front."""
CLEARANCE = 1.72
"""Mean distance of the lids' edges from the eyeball on the base mesh, as a share of 100 of its decimetres."""
CAVITY = 7.0
"""Least thickness of lips and cheeks away from the lips' edges, mm: of flat faces the mouth's inside would come out."""
CONTACT = -0.15
"""Height between the closed lips as seen from the front, mm; below 0 they overlap."""


@dataclass(frozen=True)
class Contours:
    """Vertices of the face along lids and lips; every arc from least to greatest x."""

    lids: dict[str, tuple[np.ndarray, np.ndarray]]
    """Side -> the upper and the lower lid's edge."""
    lashes: np.ndarray
    """Upper lids' outer rims, both eyes."""
    lips: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]]
    """Ring of LIPS -> its upper and its lower arc."""

    def named(self) -> dict[str, np.ndarray]:
        """The arcs that the asset carries."""
        found = {f"{side}_{which}_lid": arc for side, pair in self.lids.items()
                 for which, arc in zip(("upper", "lower"), pair, strict=True)}
        upper, lower = self.lips[420, 436]
        return found | {"upper_lip": upper, "lower_lip": lower}


def find_contours(plan: Layout, vertices: np.ndarray) -> Contours:
    """Walk the rings; `vertices` (n, 3) tell upper from lower."""
    net = QuadNet(plan.quads[(plan.part[plan.quads] == 0).all(1)])
    new = {int(old): i for i, old in enumerate(plan.source)}

    def both(edge):
        return arcs(net.ring(new[edge[0]], new[edge[1]]), vertices)

    left = both(LID)
    right = tuple(plan.mirror[arc][::-1] for arc in left)
    lashes = np.concatenate([left[0], *[both(edge)[0] for edge in LASHES]])
    lashes = np.concatenate([lashes, plan.mirror[lashes]])
    return Contours({"left": left, "right": right}, lashes, {edge: both(edge) for edge in LIPS})


def repair(vertices: np.ndarray, plan: Layout, contours: Contours) -> np.ndarray:
    """A person (n, 3) mm with eyeballs behind the lids and the mouth shut."""
    return close_lips(seat_eyeballs(vertices, plan, contours), contours)


def ball(vertices: np.ndarray, plan: Layout, side: str) -> tuple[np.ndarray, float]:
    """Centre and radius of one eyeball."""
    ids = np.flatnonzero(plan.part == {"left": 1, "right": 2}[side])
    poles = vertices[ids[[0, -1]]]
    return poles.mean(0), float(np.linalg.norm(poles[0] - poles[1]) / 2)


def seat_eyeballs(vertices: np.ndarray, plan: Layout, contours: Contours) -> np.ndarray:
    """Move each eyeball forwards or back until the lids' edges are as far from it on average as on the base."""
    out = vertices.copy()
    for side, pair in contours.lids.items():
        edge = np.concatenate(pair)
        centre, radius = ball(vertices, plan, side)
        goal = CLEARANCE / 100 * MILLIMETRES
        for _ in range(8):
            spokes = vertices[edge] - centre
            length = np.linalg.norm(spokes, axis=1)
            centre[2] += ((length - radius).mean() - goal) / (spokes[:, 2] / length).mean()
        ids = plan.part == {"left": 1, "right": 2}[side]
        out[ids] = centre + plan.ball * radius
    return out


def close_lips(vertices: np.ndarray, contours: Contours) -> np.ndarray:
    """Move the lips' rings up and down, half the way each, until none of the mouth shows between them."""
    out = vertices.copy()
    for _ in range(3):
        corner = np.abs(out[np.concatenate(contours.lips[418, 433]), 0]).max()
        share = np.linspace(-0.995, 0.995, 61)
        upper = np.min([_heights(out, contours.lips[r][0], share * corner) for r in SEAM], axis=0)
        lower = np.max([_heights(out, contours.lips[r][1], share * corner) for r in SEAM], axis=0)
        gap = np.convolve(np.pad(upper - lower - CONTACT, 1, mode="edge"), np.full(3, 1 / 3), "valid")
        gap *= np.clip((1 - np.abs(share)) / 0.03, 0, 1)
        for ring, weight in LIPS.items():
            for arc, sign in zip(contours.lips[ring], (-0.5, 0.5), strict=True):
                out[arc, 1] += sign * weight * np.interp(out[arc, 0], share * corner, gap, left=0, right=0)
    return out


def _heights(vertices: np.ndarray, arc: np.ndarray, x: np.ndarray) -> np.ndarray:
    points = vertices[arc]
    order = np.argsort(points[:, 0], kind="stable")
    return np.interp(x, points[order, 0], points[order, 1])


def thicken(vertices: np.ndarray, contours: Contours, outer: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Push the mouth's lining (`inside` (n,) true) away from the outer skin (triangles `outer`) where it is thin."""
    ids = np.flatnonzero(inside)
    near = closest_point(Mesh(vertices, outer), vertices[ids])
    normals = face_normals(vertices, outer)[near.faces]
    edge = np.concatenate([arc for ring in SEAM for arc in contours.lips[ring]])
    away = step(cKDTree(vertices[edge]).query(vertices[ids])[0], 10, 16)
    out = vertices.copy()
    out[ids] -= (away * np.maximum(CAVITY - near.distances, 0))[:, None] * normals
    return out
