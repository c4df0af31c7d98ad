"""Which landmarks of a scan a registration follows, and how far."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from ..landmarks.brow_edges import BROW_EDGES
from ..landmarks.detector import bundled_landmarks
from ..mesh import Mesh
from ..register.nonrigid import Anchors
from .terms import fading

BROWS = ("brow_right", "brow_left")
LIPS_AND_LIDS = ("lips_outer", "lips_inner", "eye_left", "eye_right")


def believed(anchors: Anchors, fitted: Mesh, slack: float) -> Anchors:
    """The same with less weight where a landmark lies far from the fitted model's."""
    missing = anchors.attachment.points(fitted) - anchors.points
    off = np.linalg.norm(missing, axis=1)
    weights = anchors.weights * fading(off, slack)
    return replace(anchors, weights=weights)


def on_brow_edges(
    anchors: Anchors, fitted: Mesh, edges: Float[np.ndarray, "2 c 3"], weight: float
) -> tuple[Anchors, tuple[str, ...]]:
    """The same with brows drawn to their upper edges alone, with `weight`, where those were found; and which brows.

    Each landmark goes to the edge's nearest point, so that it is free along the brow; beyond an end it is left out.
    """
    groups = bundled_landmarks().groups
    points = anchors.points.copy()
    weights = anchors.weights.copy()
    there = anchors.attachment.points(fitted)
    held = []
    for brow, ids, edge in zip(BROWS, BROW_EDGES, edges, strict=True):
        found = np.isfinite(edge).all(axis=1)
        if not weight or not found.any():
            continue
        held.append(brow)
        edge = edge[found]
        upper = list(ids)
        _, nearest = KDTree(edge).query(there[upper])
        last = len(edge) - 1
        beside = (nearest > 0) & (nearest < last)
        whole = groups[brow]
        weights[whole] = 0.0
        weights[upper] = weight * beside
        points[upper] = edge[nearest]
    return replace(anchors, points=points, weights=weights), tuple(held)


def of_groups(anchors: Anchors, groups: tuple[str, ...]) -> Anchors:
    """The same with the landmarks of `groups` alone."""
    sets = bundled_landmarks().groups
    members = np.concatenate([sets[name] for name in groups])
    keep = np.zeros(len(anchors.weights), bool)
    keep[members] = True
    return replace(anchors, weights=anchors.weights * keep)
