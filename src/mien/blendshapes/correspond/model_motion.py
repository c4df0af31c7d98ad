"""What the bundled expressions say of the way from the neutral to an expression, where scans have no landmark.

Past the paper: its triangles carry landmarks' motion straight across cheeks and lips. A mix of the bundled expressions
on the neutral's own mesh moves as skin does, and parts the lips along their line; landmarks then correct it.
"""

import numpy as np
from jaxtyping import Float
from scipy.optimize import lsq_linear

from ...landmarks.detector import bundled_landmarks
from ...mesh import Mesh, SurfaceImage
from ..cylinder_map import CylinderLayout, filled, outermost_first
from .landmarks import MapLandmarks, common_landmarks

MOST = 1.3
"""Largest weight of a bundled expression in the mix."""
STEADY_MM = 1.5
"""Ridge: mm of misfit at one landmark in ten that a weight of 1 must be worth."""
OFF_MM = 3.0
"""A landmark this far off the mix counts a quarter."""
ROUNDS = 3


def mix_of(
    units: Float[np.ndarray, "shapes n 3"], mesh: Mesh, source: MapLandmarks, neutral: MapLandmarks
) -> Float[np.ndarray, " shapes"]:
    """Weights of the bundled expressions that move the neutral's landmarks as the source's have moved."""
    common = common_landmarks(source, neutral)
    D = bundled_landmarks().attachment
    rows = np.einsum("kc,skcd->kds", D.barycentric[common], units[:, mesh.faces[D.faces[common]]])
    moved = source.points[common] - neutral.points[common]
    ridge = STEADY_MM * np.sqrt(common.sum() / 10) * np.eye(len(units))
    weights, hold = np.zeros(len(units)), np.ones(common.sum())
    for _ in range(ROUNDS):
        A = np.concatenate([(rows * hold[:, None, None]).reshape(-1, len(units)), ridge])
        b = np.concatenate([(moved * hold[:, None]).ravel(), np.zeros(len(units))])
        weights = np.asarray(lsq_linear(A, b, (0, MOST)).x)
        off = np.linalg.norm(moved - rows @ weights, axis=1)
        hold = 1 / (1 + (off / OFF_MM) ** 2)
    return weights


def motion_image(
    mesh: Mesh, displacement: Float[np.ndarray, "n 3"], layout: CylinderLayout
) -> Float[np.ndarray, "h w 2"]:
    """Flow (dx, dy) in the map when the mesh's vertices move (mm); beyond the mesh the nearest pixel's."""
    places, faces = outermost_first(mesh, layout)
    moves = layout.pixels(mesh.vertices + displacement) - places
    return filled(SurfaceImage(places, faces, layout.shape).draw(moves))
