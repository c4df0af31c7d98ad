"""The colours of the scans on the rig's vertices, so that an actor comes out in their own skin."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from ..mesh import Mesh, vertex_normals
from ..register import Rejection, Surface
from .scan_template import ScanTemplate

SEEN = Rejection(max_distance=2.0)
"""A scan shows the colour of a vertex that is no farther from it, faces the same way, and not beyond its rim."""
NEIGHBOURS = 8
"""Skin that no scan shows has the mean colour of so many of the nearest vertices that one shows."""
GREY = 0.5
"""sRGB where nothing is known."""
DARKEST = 1e-3
"""Luminances are compared by their ratio only where they are above it."""


def rig_colours(
    template: ScanTemplate, skin: Float[np.ndarray, "scans n 3"], scans: Sequence[Mesh]
) -> Float[np.ndarray, "all 3"] | None:
    """sRGB in 0..1 of every vertex of the template; None where the neutral scan, the first, has no colours.

    The neutral scan's where it shows the vertex; else the median of the others', brought to its exposure; else that of
    the skin nearby.

    Args:
        skin: the template's skin on every scan, face space, mm.
        scans: face space, mm.
    """
    if scans[0].colors is None:
        return None
    whole = template.mesh.with_vertices(template.whole(skin[0]))
    colours = seen_colours(whole, scans[0])
    colours[template.members] = _joined(
        colours[template.members],
        [
            seen_colours(template.skin.with_vertices(shape), scan)
            for shape, scan in zip(skin[1:], scans[1:], strict=True)
            if scan.colors is not None
        ],
    )
    return _completed(template, whole, colours)


def seen_colours(mesh: Mesh, scan: Mesh) -> Float[np.ndarray, "n 3"]:
    """Colours of a scan at the vertices of a mesh that lies on it; NaN where it does not show them."""
    normals = vertex_normals(mesh.vertices, mesh.faces)
    found = Surface(scan).correspond(mesh.vertices, normals, SEEN)
    colours = found.attachment().matrix(scan) @ scan.colors
    return np.where(found.accepted[:, None], colours, np.nan)


def _joined(first: Float[np.ndarray, "n 3"], others: list[np.ndarray]) -> Float[np.ndarray, "n 3"]:
    """The first where it is known, else the others' median."""
    if not others:
        return first
    alike = np.stack([colours * _exposure(first, colours) for colours in others])
    known = np.isfinite(alike).all(axis=2).any(axis=0)
    median = np.full_like(first, np.nan)
    median[known] = np.nanmedian(alike[:, known], axis=0)
    return np.where(np.isfinite(first), first, np.clip(median, 0.0, 1.0))


def _exposure(first: Float[np.ndarray, "n 3"], other: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " 3"]:
    """What the other's channels must be multiplied by to look as the first."""
    both = (np.nan_to_num(first) > DARKEST) & (np.nan_to_num(other) > DARKEST)
    both = both.all(axis=1)
    return np.median(first[both] / other[both], axis=0) if both.any() else np.ones(3)


def _completed(template: ScanTemplate, whole: Mesh, colours: Float[np.ndarray, "all 3"]) -> np.ndarray:
    """The same with the rest filled in: eyes and teeth as the template has them, skin from the nearest skin."""
    out = colours.copy()
    own = np.full_like(out, GREY) if whole.colors is None else whole.colors
    for members in template.parts.values():
        out[members] = np.where(np.isfinite(colours[members]), colours[members], own[members])
    known = np.isfinite(out[template.members, 0])
    if known.any():
        seen, hidden = template.members[known], template.members[~known]
        near = KDTree(whole.vertices[seen]).query(whole.vertices[hidden], k=min(NEIGHBOURS, len(seen)))[1]
        out[hidden] = out[seen[near.reshape(len(hidden), -1)]].mean(axis=1)
    return np.clip(np.nan_to_num(out, nan=GREY), 0.0, 1.0)
